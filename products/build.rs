//! Makes a module of each folder that holds a data sheet of its own name, with the bindings beside it, and the list of them.

use std::path::{Path, PathBuf};
use std::{env, fs};

use od_gen::{BindingReport, Options};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // A new folder is a new product.
    println!("cargo::rerun-if-changed=.");
    let folder = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    od_gen::build("../eds/compact.eds", "compact.rs", Options::DRIVE);
    let mut names = products(&folder);
    names.sort();
    let mut modules = String::new();
    let mut list = String::new();
    let mut arms = String::new();
    for name in &names {
        let sheet = format!("{name}/{name}.eds");
        od_gen::build(&sheet, &format!("{name}.rs"), Options::DRIVE);
        let sheet = Path::new(&sheet);
        // What is wrong with them has ended the build.
        let model = od_gen::read(sheet).expect("it was read before");
        let bindings = BindingReport::beside(sheet, &model).expect("they were read before");
        let axis = bindings.and_then(|report| report.bindings.axis);
        let title = model.device.product_name;
        let path = folder.join(sheet);
        modules += &format!(
            "/// {title}.\npub mod {name} {{\n    include!(concat!(env!(\"OUT_DIR\"), \"/{name}.rs\"));\n}}\n\n"
        );
        list += &format!(
            "    Product {{ name: {name:?}, title: {title:?}, data_sheet: include_str!({path:?}), axis: {axis:?} }},\n"
        );
        arms += &format!("        {name:?} => Some(visitor.visit::<{name}::Dictionary>()),\n");
    }
    let text = format!(
        "{modules}/// Every product, by its name.\npub const ALL: &[Product] = &[\n{list}];\n\n\
         /// Does something with the dictionary of the product of this name; `None` if there is none.\n\
         pub fn with<V: Visitor>(name: &str, visitor: V) -> Option<V::Output> {{\n    match name {{\n{arms}        \
         _ => None,\n    }}\n}}\n"
    );
    fs::write(out.join("products.rs"), text).expect("OUT_DIR can be written");
}

/// The folders that hold a data sheet of their name.
fn products(folder: &Path) -> Vec<String> {
    let folders = fs::read_dir(folder).expect("the folder of the package can be read");
    folders
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| folder.join(name).join(format!("{name}.eds")).exists())
        .collect()
}

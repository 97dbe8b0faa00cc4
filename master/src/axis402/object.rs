//! `axis402 od read` and `axis402 od write`: single objects.

use od_gen::{DataType, transfer};

use super::{Console, Node, Problem};
use crate::data_sheet::value::text;
use crate::data_sheet::{Address, DataSheet};
use crate::{Line, Master};

/// Reads objects and tells their values, each on a line behind its name; `bare` leaves the name out.
///
/// # Errors
/// [`Problem::Usage`] if there is no such object in the data sheet, [`Problem::Failed`] if the node refuses or does not answer.
pub fn read<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    objects: &[String],
    data_type: Option<DataType>,
    bare: bool,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    // A mistake in the last name shows before the first object is read.
    let addresses = objects.iter().map(|object| find(&node.sheet, object));
    for address in addresses.collect::<Result<Vec<_>, _>>()? {
        let bytes = node
            .upload(master, address)
            .map_err(|failure| Problem::with_node(node.id, failure))?;
        let data_type = data_type.or_else(|| node.sheet.data_type(address));
        let value = text(address, &bytes, data_type);
        if bare {
            console.say(&value)?;
        } else {
            console.say(&format!("{}: {value}", node.title(address)))?;
        }
    }
    Ok(())
}

/// Writes an object.
///
/// # Errors
/// [`Problem::Usage`] if there is no such object, its type is not known, or the value does not fit it; [`Problem::Failed`] if the
/// node refuses or does not answer.
pub fn write<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    object: &str,
    value: &str,
    data_type: Option<DataType>,
) -> Result<(), Problem> {
    let address = find(&node.sheet, object)?;
    let known = data_type.or_else(|| node.sheet.data_type(address));
    let data_type = known.ok_or_else(|| {
        Problem::Usage(format!(
            "the type of {address} is not known: --type says it, or --eds the data sheet"
        ))
    })?;
    // A DOMAIN has no text of its own; its bytes are written as those of an OCTET_STRING.
    let written_as = match data_type {
        DataType::Domain => DataType::OctetString,
        other => other,
    };
    let value = transfer::parse(value, written_as)
        .map_err(|why| Problem::Usage(format!("{}: {why}", node.title(address))))?;
    let bytes = transfer::bytes(&value, written_as, node.id);
    node.download(master, address, &bytes)
        .map_err(|failure| Problem::with_node(node.id, failure))
}

/// The bytes of an object as they travel: of a DOMAIN the file that the device keeps there.
///
/// # Errors
/// As [`read`].
pub fn fetch<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    object: &str,
) -> Result<Vec<u8>, Problem> {
    let address = find(&node.sheet, object)?;
    node.upload(master, address)
        .map_err(|failure| Problem::with_node(node.id, failure))
}

/// Writes bytes as they are, as [`fetch`] reads them.
///
/// # Errors
/// As [`write()`].
pub fn put<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    object: &str,
    bytes: &[u8],
) -> Result<(), Problem> {
    let address = find(&node.sheet, object)?;
    node.download(master, address, bytes)
        .map_err(|failure| Problem::with_node(node.id, failure))
}

fn find(sheet: &DataSheet, object: &str) -> Result<Address, Problem> {
    sheet.find(object).map_err(Problem::Usage)
}

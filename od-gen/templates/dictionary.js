// The search hides what does not hold every word that is typed; an index may be typed as 6040, 6040h or 0x6040.
const search = document.getElementById("search");
const found = document.getElementById("found");
const objects = Array.from(document.querySelectorAll(".object"), (article) => ({
  article,
  link: document.querySelector(`nav [data-for="${article.id}"]`),
  text: article.textContent.toLowerCase().replace(/\s+/g, " "),
}));
const groups = Array.from(document.querySelectorAll(".group"));
const others = ["device", "pdos"].map((id) => document.getElementById(id)).filter(Boolean);

function show() {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean)
    .map((word) => word.replace(/^0x(?=[0-9a-f]{4}$)/, ""));
  let count = 0;
  for (const { article, link, text } of objects) {
    const fits = words.every((word) => text.includes(word));
    article.hidden = !fits;
    link.hidden = !fits;
    count += fits;
  }
  for (const group of groups) {
    group.hidden = !group.querySelector(".object:not([hidden])");
    document.querySelector(`nav a[href="#${group.id}"]`).parentElement.hidden = group.hidden;
  }
  for (const other of others) other.hidden = words.length > 0;
  found.textContent = words.length === 0 ? "" : `${count} of ${objects.length} objects`;
}

search.addEventListener("input", show);
document.addEventListener("keydown", (event) => {
  if (event.key === "/" && document.activeElement !== search) {
    event.preventDefault();
    search.focus();
  } else if (event.key === "Escape" && document.activeElement === search) {
    search.value = "";
    show();
  }
});
// A link into what the search has hidden shows it.
window.addEventListener("hashchange", () => {
  const target = document.getElementById(location.hash.slice(1));
  if (target && target.closest("[hidden]")) {
    search.value = "";
    show();
    target.scrollIntoView();
  }
});
show();

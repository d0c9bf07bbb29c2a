// Cards of many results: sorted, filtered by words and bars, rated; each opens as a page of its own, by the address's
// hash. A card is drawn when it comes near the window, so that a page of ten thousand opens within two seconds. Ratings
// stay in this browser until they are saved as a file.
const sheet = document.querySelector(".sheet"), form = document.querySelector(".toolbar");
const dialog = document.querySelector("dialog"), title = document.title;
const key = "igl_spheremap ratings " + location.pathname;
let ratings = {}, bar = null;  // the bar of a histogram that was clicked: cards outside of it are hidden
try { ratings = JSON.parse(localStorage.getItem(key)) || {}; } catch { /* a browser that keeps nothing */ }
const add = (parent, tag, properties = {}) => parent.appendChild(Object.assign(document.createElement(tag), properties));
const data = JSON.parse(document.querySelector(".cards").textContent);
const cards = data.cards.map(card => ({...card,
  element: Object.assign(document.createElement("div"), {id: card.key, className: card.good ? "card" : "card bad"})}));
const byElement = new Map(cards.map(card => [card.element, card]));
const rated = row => ratings[row.source] || {rating: "", comment: ""};

function rate(row, change) {
  ratings[row.source] = {...rated(row), ...change};
  store();
}

function store() {
  try { localStorage.setItem(key, JSON.stringify(ratings)); } catch { /* a browser that keeps nothing */ }
  show();
}

function addRating(parent, row) {
  const box = add(parent, "div", {className: "rating"});
  for (const rating of ["pass", "fail"])
    add(box, "button", {type: "button", textContent: rating,
      onclick: () => rate(row, {rating: rated(row).rating === rating ? "" : rating})});
  add(box, "input", {placeholder: "comment", ariaLabel: "comment",
    oninput: event => rate(row, {comment: event.target.value})});
}

function showRating(parent, row) {
  const {rating, comment} = rated(row), box = parent.querySelector(".rating");
  for (const button of box.querySelectorAll("button")) button.ariaPressed = button.textContent === rating;
  const input = box.querySelector("input");
  if (input.value !== comment) input.value = comment;
}

// A name that may wrap after its separators.
function addName(parent, name) {
  for (const part of name.split(/(?<=[/_.-])(?=[^/_.-])/)) { parent.append(part); add(parent, "wbr"); }
}

function draw({element, row, name, text, picture, badges}) {
  const link = add(element, "a", {href: "#" + element.id});
  if (picture) add(link, "img", {alt: "", src: picture});
  addName(add(link, "div"), name);
  add(link, "small", {textContent: text});
  const box = add(element, "div");
  for (const badge of badges) { add(box, "span", {className: "badge", textContent: badge}); box.append(" "); }
  addRating(element, row);
  showRating(element, row);
}

const near = new IntersectionObserver(entries => {
  for (const {isIntersecting, target} of entries)
    if (isIntersecting) { near.unobserve(target); draw(byElement.get(target)); }
}, {rootMargin: "1000px"});

const shown = () => cards.filter(({element}) => !element.hidden);
const inBar = row => !bar || (row[bar.figure] !== null && (bar.high === "" ? row[bar.figure] > +bar.low
  : row[bar.figure] >= +bar.low && row[bar.figure] < +bar.high));

function show() {
  const status = form.status.value, text = form.text.value.toLowerCase();
  const asked = {"passed": "pass", "failed by you": "fail", "not rated": ""}[status];
  for (const {element, row, reasons} of cards) {
    const {rating} = rated(row);
    const chosen = status === "all" || (status === "outliers" ? reasons.length > 0
      : asked === undefined ? row.status === status : rating === asked);
    if (element.firstChild) showRating(element, row);
    element.hidden = !(chosen && row.source.toLowerCase().includes(text) && inBar(row));
  }
  form.querySelector("output").value = `${shown().length} of ${cards.length}`;
  form.bars.hidden = !bar;
  form.bars.textContent = bar ? `${bar.said} \u00d7` : "";
  for (const one of document.querySelectorAll(".bar[data-figure]")) one.classList.toggle("chosen", one.dataset === bar);
  const open = opened();
  if (open) showRating(dialog, open.row);
}

function sort() {
  const name = form.sort.value, up = name === "rank" || name === "source" ? 1 : -1;
  const value = card => (name === "rank" ? card.rank : card.row[name]) ?? -Infinity;
  cards.sort((a, b) => up * (value(a) > value(b) ? 1 : value(a) < value(b) ? -1 : 0));
  const all = document.createDocumentFragment();
  for (const {element} of cards) all.append(element);
  sheet.append(all);
}

// The page of one card, by the address's hash; its neighbours are those that the sheet shows, in its order.
const opened = () => cards.find(({element}) => element.id === location.hash.slice(1));
function step(by) {
  const list = shown(), next = list[list.indexOf(opened()) + by];
  if (next) location.replace("#" + next.element.id);
}
function open() {
  const card = opened();
  if (!card) { if (dialog.open) dialog.close(); document.title = title; return; }
  const {row, reasons, caption, command, picture} = card, list = shown(), place = list.indexOf(card);
  dialog.textContent = "";
  const steps = add(dialog, "div", {className: "steps"});
  add(steps, "button", {type: "button", textContent: "\u2190 previous", disabled: place < 1, onclick: () => step(-1)});
  add(steps, "button", {type: "button", textContent: "next \u2192", disabled: place < 0 || place > list.length - 2, onclick: () => step(1)});
  add(steps, "span", {textContent: place < 0 ? "" : `${place + 1} of ${list.length}`});
  add(steps, "button", {type: "button", textContent: "all", onclick: () => dialog.close()});
  add(dialog, "h1", {textContent: row.source});
  addRating(dialog, row);
  if (picture) {
    add(add(dialog, "p"), "img", {src: picture, alt: row.source});
    add(dialog, "p", {textContent: caption});
    dialog.append(document.querySelector(".legends").cloneNode(true));
  }
  for (const reason of reasons) add(dialog, "span", {className: "badge", textContent: reason});
  const table = add(dialog, "table");
  for (const [name, value] of Object.entries(row)) {
    const line = add(table, "tr");
    add(line, "th", {scope: "row", textContent: data.labels[name] ?? name.replaceAll("_", " ")});
    add(line, "td", {textContent: value === null ? "none" : typeof value === "number" ? +value.toPrecision(6) : String(value)});
  }
  add(dialog, "pre", {textContent: command});
  document.title = row.source;
  showRating(dialog, row);
  if (!dialog.open) dialog.showModal();
  dialog.scrollTop = 0;
}
dialog.onclose = () => {
  const card = opened();
  history.replaceState(null, "", location.pathname + location.search);
  document.title = title;
  if (card) card.element.scrollIntoView({block: "center"});
};
onkeydown = event => {
  if (dialog.open && event.target.tagName !== "INPUT" && (event.key === "ArrowLeft" || event.key === "ArrowRight"))
    step(event.key === "ArrowLeft" ? -1 : 1);
};
onhashchange = open;

for (const one of document.querySelectorAll(".bar[data-figure]"))
  one.onclick = () => { bar = bar === one.dataset ? null : one.dataset; show(); form.scrollIntoView({block: "nearest"}); };
form.bars.onclick = () => { bar = null; show(); };
form.onsubmit = event => event.preventDefault();
form.oninput = show;
form.sort.onchange = sort;
form.load.onchange = async () => {
  // What was saved: cells in quotes have theirs doubled, and a cell that a spreadsheet took for a formula has one before it.
  const plain = cell => (/^".*"$/.test(cell) ? cell.slice(1, -1).replaceAll('""', '"') : cell).replace(/^'(?=[=+\-@'])/, "");
  for (const line of (await form.load.files[0].text()).split(/\r?\n/).slice(1).filter(Boolean)) {
    const [source, , rating, comment] = line.split("\t").map(plain);
    ratings[source] = {rating: rating ?? "", comment: comment ?? ""};
  }
  form.load.value = "";
  store();
};
form.querySelector("[name=export]").onclick = () => {
  // No spreadsheet takes a cell for a formula, and quotes are doubled, as in all tables of the package.
  const safe = text => String(text).replace(/[\t\r\n]+/g, " ").replace(/^(?=[=+\-@'])/, "'");
  const cell = text => /"/.test(text) ? `"${safe(text).replaceAll('"', '""')}"` : safe(text);
  const lines = cards.map(({row}) => [row.source, row.status, rated(row).rating, rated(row).comment].map(cell).join("\t"));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([["source\tstatus\trating\tcomment", ...lines, ""].join("\n")]));
  link.download = "ratings.tsv";
  link.click();
};
sort();
show();
for (const {element} of cards) near.observe(element);
open();

// Cards of a population: sorted, filtered and rated. Ratings stay in this browser until they are saved as a file.
const sheet = document.querySelector(".sheet"), form = document.querySelector(".toolbar");
const key = "igl_spheremap ratings " + location.pathname;
let ratings = {};
try { ratings = JSON.parse(localStorage.getItem(key)) || {}; } catch { /* a browser that keeps nothing */ }
const cards = [...sheet.children].map(element => ({element, row: JSON.parse(element.dataset.row)}));
const rated = row => ratings[row.source] ||= {rating: "", comment: ""};

function keep() {
  try { localStorage.setItem(key, JSON.stringify(ratings)); } catch { /* as above */ }
  show();
}

for (const {element, row} of cards) {
  const bar = element.appendChild(document.createElement("div"));
  bar.className = "rating";
  for (const rating of ["pass", "fail"]) {
    const button = bar.appendChild(document.createElement("button"));
    button.type = "button";
    button.textContent = rating;
    button.onclick = () => { rated(row).rating = rated(row).rating === rating ? "" : rating; keep(); };
  }
  const comment = bar.appendChild(document.createElement("input"));
  comment.placeholder = "comment";
  comment.value = rated(row).comment;
  comment.oninput = () => { rated(row).comment = comment.value; keep(); };
}

function show() {
  const status = form.status.value, text = form.text.value.toLowerCase();
  const asked = {"passed": "pass", "failed by you": "fail", "not rated": ""}[status];
  let count = 0;
  for (const {element, row} of cards) {
    const {rating} = rated(row);
    for (const button of element.querySelectorAll("button")) button.ariaPressed = button.textContent === rating;
    element.hidden = !(row.source.toLowerCase().includes(text)
      && (status === "all" || (asked === undefined ? row.status === status : rating === asked)));
    count += !element.hidden;
  }
  form.querySelector("output").value = `${count} of ${cards.length}`;
}

function sort() {
  const name = form.sort.value, up = name === "rank" || name === "source" ? 1 : -1;
  const value = ({row}) => row[name] ?? -Infinity;
  cards.sort((a, b) => up * (value(a) > value(b) ? 1 : value(a) < value(b) ? -1 : 0));
  sheet.append(...cards.map(card => card.element));
}

form.onsubmit = event => event.preventDefault();
form.oninput = show;
form.sort.onchange = sort;
form.querySelector("[name=export]").onclick = () => {
  const cell = text => String(text).replace(/[\t\r\n]+/g, " ").replace(/^(?=[=+\-@'])/, "'");
  const lines = cards.map(({row}) => [row.source, row.status, rated(row).rating, rated(row).comment].map(cell).join("\t"));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([["source\tstatus\trating\tcomment", ...lines, ""].join("\n")]));
  link.download = "ratings.tsv";
  link.click();
};
show();

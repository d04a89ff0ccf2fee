// Measures the page in which it stands, and tells the page around it. What is wrong is a list of sentences.
addEventListener("load", () => {
  // Before anything is pressed: what the charts show first.
  const firstShown = document.getElementById("shown").textContent;
  const wrong = [], root = document.documentElement, width = root.clientWidth;
  const name = (it) => it.tagName + (it.id ? "#" + it.id : "") + (it.getAttribute("class") ? "." + it.getAttribute("class") : "");
  const note = (text) => { if (wrong.length < 20) wrong.push(text); };
  document.querySelectorAll("details").forEach((details) => { details.open = true; });

  // Nothing reaches beyond the page, and nothing has more in it than it shows.
  if (root.scrollWidth > width) note(`the page needs ${root.scrollWidth} pixels`);
  const seen = [...document.querySelectorAll("main *")].filter((it) => it.getClientRects().length > 0);
  for (const it of seen) {
    const box = it.getBoundingClientRect();
    const picture = it.ownerSVGElement;
    if (!picture && (box.right > width + 1 || box.left < -1)) note(`${name(it)} reaches from ${box.left} to ${box.right}`);
    const isInline = getComputedStyle(it).display === "inline" || picture || it.tagName === "OPTION" || it.tagName === "SELECT";
    if (!isInline && it.clientWidth > 0 && it.scrollWidth > it.clientWidth + 1) note(`${name(it)} shows ${it.clientWidth} of ${it.scrollWidth}`);
  }
  // No label is cut off by its picture, and no two labels of the time cover each other.
  let smallest = Infinity;
  for (const picture of document.querySelectorAll("main svg")) {
    const outer = picture.getBoundingClientRect();
    const labels = [...picture.querySelectorAll("text")];
    for (const label of labels) {
      const box = label.getBoundingClientRect();
      smallest = Math.min(smallest, parseFloat(getComputedStyle(label).fontSize) * outer.width / picture.viewBox.baseVal.width);
      if (box.left < outer.left - 1 || box.right > outer.right + 1 || box.top < outer.top - 1 || box.bottom > outer.bottom + 1) {
        note(`the label ${label.textContent} of ${picture.getAttribute("aria-label")} is cut off`);
      }
    }
    const along = labels.filter((label) => label.classList.contains("x")).map((label) => label.getBoundingClientRect());
    along.sort((a, b) => a.left - b.left);
    along.forEach((box, n) => { if (n > 0 && box.left < along[n - 1].right) note("labels cover each other in " + picture.getAttribute("aria-label")); });
  }
  for (const it of seen.filter((it) => [...it.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim()))) {
    smallest = Math.min(smallest, parseFloat(getComputedStyle(it).fontSize));
    const ratio = contrast(it);
    if (ratio < 3) note(`${name(it)} has a contrast of ${ratio.toFixed(1)}`);
  }

  // Every chart answers to the pointer and to the keys.
  let charts = 0;
  for (const picture of document.querySelectorAll("main svg")) {
    const label = picture.getAttribute("aria-label"), figure = picture.parentElement;
    charts++;
    const before = picture.innerHTML;
    picture.focus();
    picture.dispatchEvent(new KeyboardEvent("keydown", { key: "+", bubbles: true }));
    if (picture.innerHTML === before) note(`${label} does not zoom`);
    picture.dispatchEvent(new KeyboardEvent("keydown", { key: "0", bubbles: true }));
    if (!hovers(picture, figure)) note(`${label} does not say what is under the pointer`);
  }
  const all = document.querySelector("[data-view=all]");
  all.click();
  const canvas = document.getElementById("strip"), pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  if (!pixels.some((value, place) => place % 4 === 3 && value > 0)) note("no frame is drawn");

  // At its middle, at a dot, on a curve.
  function hovers(picture, figure) {
    const box = picture.getBoundingClientRect();
    const places = [[box.left + box.width / 2, box.top + box.height / 2]];
    for (const dot of [...picture.querySelectorAll("circle.dot:not([visibility=hidden])")].slice(0, 3)) {
      places.push([box.left + dot.cx.baseVal.value, box.top + dot.cy.baseVal.value]);
    }
    const curve = picture.querySelector("path.curve");
    if (curve && curve.getTotalLength() > 0) {
      const { x, y } = curve.getPointAtLength(curve.getTotalLength() / 2);
      places.push([box.left + x, box.top + y]);
    }
    return places.some(([clientX, clientY]) => {
      picture.dispatchEvent(new PointerEvent("pointermove", { clientX, clientY, bubbles: true }));
      return [...figure.querySelectorAll(".reading, .chart-head b, .chart-time")].some((it) => it.textContent.trim() !== "");
    });
  }

  function contrast(it) {
    const numbers = (text) => (text.match(/[\d.]+/g) ?? []).map(Number);
    const light = ([r, g, b]) => [r, g, b].map((value) => value / 255)
      .map((value) => (value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4))
      .reduce((sum, value, n) => sum + value * [0.2126, 0.7152, 0.0722][n], 0);
    const style = getComputedStyle(it);
    const front = light(numbers(it.ownerSVGElement ? style.fill : style.color));
    let behind = it, color;
    do {
      color = numbers(getComputedStyle(behind).backgroundColor);
      behind = behind.parentElement;
    } while (behind && color.length === 4 && color[3] === 0);
    const back = light(color);
    return (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05);
  }

  parent.document.body.setAttribute("data-measured", JSON.stringify({
    width, smallest, charts, wrong,
    dark: matchMedia("(prefers-color-scheme: dark)").matches,
    paper: getComputedStyle(document.body).backgroundColor,
    events: document.querySelectorAll("#marks option").length,
    rows: document.querySelectorAll("#axes-table tbody tr").length,
    fault: document.querySelector(".first-fault")?.textContent ?? "",
    begins: firstShown,
  }));
});

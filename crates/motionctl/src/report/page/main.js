// Puts the page together.

facts();
axisTable();
axes.forEach((_, axis) => chartsOf(document.getElementById("axes"), axis));
if (axes.length >= 2 && !isSpeed) new Path(document.getElementById("path")); else document.getElementById("path-section").hidden = true;
busCharts(document.getElementById("bus"));
const jitter = new Jitter(document.getElementById("jitter"));
jitterFacts();
eventTable();
strip();

function jitterFacts() {
  const within = (us) => data.deviationsUs.reduce((sum, [by, count]) => sum + (Math.abs(by) <= us ? count : 0), 0);
  const all = within(Infinity), share = (us) => (all ? (100 * within(us)) / all : 100).toFixed(2);
  document.getElementById("jitter-facts").textContent =
    `${all} intervals: ${share(10)} % within 10 us of the cycle, ${share(100)} % within 100 us.` +
    (data.origin === "simulation" ? "" : " The times are those at which this computer or its adapter had the frames.");
}

const about = (at, by) => timeView.show(at - by, at + by);
const controls = {
  in: () => timeView.zoom(0.5), out: () => timeView.zoom(2), left: () => timeView.move(-0.5), right: () => timeView.move(0.5),
  all: () => timeView.all(), fault: () => firstFault && about(firstFault[0] / 1e6, 0.25),
};
document.querySelectorAll("[data-view]").forEach((button) => {
  button.addEventListener("click", controls[button.dataset.view]);
  if (button.dataset.view === "fault") button.hidden = !firstFault;
});
const shown = document.getElementById("shown");
timeView.charts.push({ draw() { shown.textContent = `${timeView.from.toFixed(3)} to ${timeView.to.toFixed(3)} s`; }, point() {} });
if (firstFault) controls.fault(); else timeView.all();

function redraw() {
  timeView.redraw();
  jitter.view.redraw();
  drawStrip();
}
let waiting = 0;
addEventListener("resize", () => {
  cancelAnimationFrame(waiting);
  waiting = requestAnimationFrame(redraw);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
addEventListener("beforeprint", () => {
  printWidth = 680;
  document.documentElement.dataset.print = "";
  document.querySelectorAll("details").forEach((details) => { details.open = true; });
  redraw();
});
addEventListener("afterprint", () => {
  printWidth = null;
  delete document.documentElement.dataset.print;
  redraw();
});

// The frames on the wire: one row for each drive, at any zoom.

let drawStrip = () => {};

function strip() {
  const canvas = document.getElementById("strip");
  const reading = document.getElementById("reading");
  const marks = document.getElementById("marks");
  const context = canvas.getContext("2d");

  const LEFT = 74, ROW = 34, BAR = 22, AXIS = 44, TOP = 6;
  const bitUs = data.bitNs / 1000;
  const rows = ["all", ...data.axes.map((axis) => axis.drive)];
  const height = TOP + rows.length * ROW + AXIS;
  const events = data.events.filter((event) => event[2] !== "state").slice(0, 1000);
  const colors = { p: "--set-point", q: "--request", r: "--reply", a: "--alarm", e: "--destroyed" };

  // Each text is "class|frame|meaning"; the frame tells the drive: its identifier is drive * 32 + function, and on CANopen function * 128 + node.
  const texts = data.texts.map((text) => {
    const [kind, frame, ...meaning] = text.split("|");
    const id = parseInt(frame.slice(0, 3), 16), drive = isSpeed ? id & 0x7f : id >> 5;
    return { kind, frame, meaning: meaning.join("|"), row: Math.max(0, rows.indexOf(drive)) };
  });
  const frames = unpack(data.frames);

  // Time since the frame before in 100 ns, length in bits, number of the text.
  function unpack(block) {
    const numbers = numbersOf(block), result = { startUs: [], endUs: [], text: [] };
    let time = 0;
    for (let n = 0; n < numbers.length; n += 3) {
      time += signed(numbers[n]);
      result.startUs.push(time / 10);
      result.endUs.push(time / 10 + numbers[n + 1] * bitUs);
      result.text.push(numbers[n + 2]);
    }
    return result;
  }

  // What is shown, in microseconds: first the first fault, else the begin of the motion, or what is left of it.
  const motionUs = data.motionStart ? data.motionStart[0] : 0;
  const begin = Math.max(firstFault ? firstFault[0] - 2 * data.cycleUs : motionUs, frames.startUs[0] ?? 0);
  let from = begin - data.cycleUs * 0.5, to = begin + data.cycleUs * 5.5;

  const width = () => printWidth ?? canvas.clientWidth;
  const x = (us) => LEFT + ((us - from) / (to - from)) * (width() - LEFT);
  const us = (px) => from + ((px - LEFT) / (width() - LEFT)) * (to - from);
  const rowTop = (row) => TOP + row * ROW + (ROW - BAR) / 2;

  // Index of the first frame that ends behind a time.
  function firstEndingAfter(timeUs) {
    let low = 0, high = frames.endUs.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (frames.endUs[middle] > timeUs) high = middle; else low = middle + 1;
    }
    return low;
  }

  function draw() {
    const scale = devicePixelRatio || 1;
    canvas.width = Math.round(width() * scale);
    canvas.height = Math.round(height * scale);
    canvas.style.height = height + "px";
    canvas.style.width = printWidth ? printWidth + "px" : "";
    context.setTransform(scale, 0, 0, scale, 0, 0);
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(name).trim();
    context.clearRect(0, 0, width(), height);
    context.font = '13px system-ui, "DejaVu Sans", sans-serif';
    context.textBaseline = "middle";
    drawAxis(color);
    drawFrames(color);
    drawRows(color);
  }

  function drawRows(color) {
    context.fillStyle = color("--panel");
    context.fillRect(0, 0, LEFT, height);
    context.textAlign = "right";
    context.fillStyle = color("--ink");
    rows.forEach((drive, row) => {
      context.fillText(drive === "all" ? "all drives" : driveWord + " " + drive, LEFT - 8, rowTop(row) + BAR / 2);
    });
  }

  function drawAxis(color) {
    const bottom = TOP + rows.length * ROW;
    const step = niceStep((to - from) / 8);
    const digits = step >= 1e5 ? 1 : step >= 1e3 ? 3 : step >= 1 ? 6 : 7;
    context.strokeStyle = color("--grid");
    context.fillStyle = color("--ink");
    context.lineWidth = 1;
    context.beginPath();
    rows.forEach((_, row) => line(LEFT, TOP + (row + 1) * ROW, width(), TOP + (row + 1) * ROW));
    for (let tick = Math.ceil(from / step) * step; tick <= to; tick += step) {
      line(x(tick), TOP, x(tick), bottom + 5);
      const label = (tick / 1e6).toFixed(digits), half = context.measureText(label).width / 2;
      context.textAlign = "center";
      if (x(tick) - half > LEFT && x(tick) + half < width()) context.fillText(label, x(tick), bottom + 14);
    }
    context.stroke();
    context.fillText("time, s", LEFT + (width() - LEFT) / 2, bottom + 33);
    context.strokeStyle = color("--cause");
    context.beginPath();
    for (const [at] of events) if (at >= from && at <= to) line(x(at), TOP, x(at), bottom);
    context.stroke();
  }

  function line(x1, y1, x2, y2) {
    context.moveTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
    context.lineTo(Math.round(x2) + 0.5, Math.round(y2) + 0.5);
  }

  function niceStep(least) {
    const power = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= least);
  }

  function drawFrames(color) {
    const palette = Object.fromEntries(Object.entries(colors).map(([kind, name]) => [kind, color(name)]));
    const paper = color("--paper");
    const drawn = new Map();
    context.textAlign = "center";
    for (let index = firstEndingAfter(from); index < frames.startUs.length && frames.startUs[index] < to; index++) {
      const text = texts[frames.text[index]];
      const left = x(frames.startUs[index]), wide = Math.max(1, x(frames.endUs[index]) - left);
      // Far out many frames share a pixel: one of each kind is enough.
      const key = text.row + text.kind, pixel = Math.round(left);
      if (wide < 2 && drawn.get(key) === pixel) continue;
      drawn.set(key, pixel);
      context.fillStyle = palette[text.kind];
      context.fillRect(left, rowTop(text.row), wide, BAR);
      if (wide > context.measureText(text.frame).width + 8) {
        context.fillStyle = paper;
        context.fillText(text.frame, left + wide / 2, rowTop(text.row) + BAR / 2 + 1);
      }
    }
  }

  function show(start, end) {
    const span = Math.min(Math.max(end - start, 20), data.endUs * 1.02 + 1);
    from = Math.min(Math.max((start + end - span) / 2, -0.01 * data.endUs), Math.max(0, data.endUs * 1.01 - span));
    to = from + span;
    draw();
  }

  const zoom = (factor, centre) => show(centre - (centre - from) * factor, centre + (to - centre) * factor);
  const move = (share) => show(from + (to - from) * share, to + (to - from) * share);
  const middle = () => (from + to) / 2;
  const actions = {
    in: () => zoom(0.5, middle()), out: () => zoom(2, middle()),
    left: () => move(-0.5), right: () => move(0.5), all: () => show(beginS * 1e6, data.endUs),
  };

  function read(event) {
    const box = canvas.getBoundingClientRect();
    const at = us(event.clientX - box.left), row = Math.floor((event.clientY - box.top - TOP) / ROW);
    const slack = ((to - from) / width()) * 2;
    for (let index = firstEndingAfter(at - slack); index < frames.startUs.length && frames.startUs[index] <= at + slack; index++) {
      const text = texts[frames.text[index]];
      if (text.row !== row) continue;
      const bits = Math.round((frames.endUs[index] - frames.startUs[index]) / bitUs);
      reading.textContent = (frames.startUs[index] / 1e6).toFixed(6) + " s  " + text.frame + "  " + text.meaning + "  (" + bits + " bits)";
      return;
    }
    reading.textContent = "\u00a0";
  }

  let grabbed = null;
  canvas.addEventListener("pointerdown", (event) => {
    grabbed = event.clientX;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (grabbed === null) return read(event);
    const by = ((grabbed - event.clientX) / (width() - LEFT)) * (to - from);
    grabbed = event.clientX;
    show(from + by, to + by);
  });
  canvas.addEventListener("pointerup", () => { grabbed = null; });
  canvas.addEventListener("wheel", (event) => {
    // Without a key the wheel moves the page.
    if (!event.ctrlKey && document.activeElement !== canvas) return;
    event.preventDefault();
    zoom(event.deltaY > 0 ? 1.25 : 0.8, us(event.clientX - canvas.getBoundingClientRect().left));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const action = { "+": "in", "-": "out", ArrowLeft: "left", ArrowRight: "right", 0: "all" }[event.key];
    if (!action) return;
    event.preventDefault();
    actions[action]();
  });
  document.querySelectorAll("[data-do]").forEach((button) => button.addEventListener("click", actions[button.dataset.do]));
  events.forEach((event, index) => marks.add(new Option(eventText(event), index)));
  const goTo = (index) => {
    if (!events[index]) return;
    const at = events[index][0];
    show(at - data.cycleUs * 2, at + data.cycleUs * 6);
    about(at / 1e6, Math.max((timeView.to - timeView.from) / 2, 1e-3));
  };
  marks.addEventListener("change", () => goTo(Number(marks.value)));
  if (firstFault) marks.value = String(events.indexOf(firstFault));
  stripNote();
  drawStrip = draw;
  draw();
}

function stripNote() {
  const all = data.framesForgotten;
  document.getElementById("strip-note").textContent = all === 0
    ? "Every frame of the recording."
    : `The newest frames; ${all} before them are not in the page, --candump and --mcap keep everything.`;
}

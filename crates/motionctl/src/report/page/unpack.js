// The numbers of the page. Everything that is drawn or printed comes from this one block.

const data = JSON.parse(document.getElementById("data").textContent);

// Numbers in groups of seven bits, least significant first, the top bit set while more follow.
function numbersOf(block) {
  const bytes = Uint8Array.from(atob(block), (char) => char.charCodeAt(0));
  const numbers = [];
  for (let place = 0; place < bytes.length;) {
    let number = 0, weight = 1, byte;
    do {
      byte = bytes[place++];
      number += (byte & 0x7f) * weight;
      weight *= 128;
    } while (byte & 0x80);
    numbers.push(number);
  }
  return numbers;
}

// 0, 1, 2, 3 ... are 0, -1, 1, -2 ...
const signed = (number) => (number % 2 ? -(number + 1) / 2 : number / 2);

// Differences from one number to the next.
function series(block) {
  let value = 0;
  return Float64Array.from(numbersOf(block), (number) => (value += signed(number)));
}

// Pairs: how many samples further, and the difference of the values.
function sparse(block) {
  const numbers = numbersOf(block), index = [], values = [];
  let place = -1, value = 0;
  for (let pair = 0; pair < numbers.length; pair += 2) {
    index.push((place += numbers[pair]));
    values.push((value += signed(numbers[pair + 1])));
  }
  return { index, values: Float64Array.from(values) };
}

const times = series(data.samples.timesUs).map((us) => us / 1e6);
const cycleNumbers = series(data.samples.numbers);
const loads = series(data.samples.loadPermille).map((permille) => permille / 10);
const isLog = data.origin === "log";
// Wheels follow speeds, which begin at 0.
const isSpeed = data.quantity === "speed";
const endS = data.endUs / 1e6;
const startIndex = data.motionStart ? Math.max(0, times.findIndex((at) => at >= data.motionStart[0] / 1e6)) : 0;
const driveWord = isSpeed ? "node" : "drive";
const name = (axis) => data.axes[axis].name + (data.axes[axis].name.startsWith(driveWord + " ") ? "" : `, ${driveWord} ${data.axes[axis].drive}`);

// Each axis in its unit: the value at the begin of the motion is the first one of the file.
const axes = data.axes.map((about) => {
  const sentCounts = series(about.sent);
  const targetCounts = about.target ? series(about.target) : sentCounts;
  const origin = isSpeed ? 0 : targetCounts[startIndex] ?? 0;
  const inUnit = (counts) => about.start + (counts - origin) / about.countsPerUnit;
  const curve = (pairs, value) => ({
    x: Float64Array.from(pairs.index, (place) => times[place]),
    y: pairs.values.map(value),
    place: pairs.index,
  });
  const position = sparse(about.position);
  const target = { x: times, y: targetCounts.map(inUnit) };
  const sent = { x: times, y: sentCounts.map(inUnit) };
  const motor = curve(position, inUnit);
  const error = {
    x: motor.x,
    y: position.values.map((counts, n) => (targetCounts[position.index[n]] - counts) / about.countsPerUnit),
  };
  return {
    about, target, sent, motor, error,
    backlog: { x: times, y: targetCounts.map((counts, n) => (counts - sentCounts[n]) / (isSpeed ? about.countsPerUnit : 1)) },
    statusAge: curve(sparse(about.statusAgeUs), (us) => us / 1000),
    positionAge: curve(sparse(about.positionAgeUs), (us) => us / 1000),
    setPointVelocity: velocity(target.x, target.y, cycleNumbers),
    motorVelocity: velocity(motor.x, motor.y, null),
  };
});


// Over five cycles, so that whole counts do not make it jump.
function velocity(x, y, numbers) {
  const span = (data.cycleUs / 1e6) * 5 * 0.999;
  const result = { x: [], y: [] };
  let before = 0;
  for (let n = 1; n < x.length; n++) {
    // A log has the times of its frames alone; a master counts its cycles.
    const between = (from) => (numbers && !isLog ? (numbers[n] - numbers[from]) * (data.cycleUs / 1e6) : x[n] - x[from]);
    while (before + 1 < n && between(before + 1) >= span) before++;
    const seconds = between(before);
    // Two frames that a computer wrote down at once tell no velocity.
    if (seconds < span * 0.5) continue;
    result.x.push(x[n]);
    result.y.push((y[n] - y[before]) / seconds);
  }
  return { x: Float64Array.from(result.x), y: Float64Array.from(result.y) };
}

const largest = (values) => values.reduce((most, value) => (Math.abs(value) > Math.abs(most) ? value : most), 0);
const lastOf = (values) => (values.length ? values[values.length - 1] : NaN);
const firstFault = data.events.find((event) => event[2] === "fault");

// Three or four digits, without an exponent where that is short enough.
function text(value) {
  if (!Number.isFinite(value)) return "-";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e9)) return value.toExponential(2);
  const digits = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : size >= 1 ? 3 : 4;
  return String(Number(value.toFixed(digits))).replace("-", "\u2212");
}

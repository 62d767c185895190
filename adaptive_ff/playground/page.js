'use strict';
const content = JSON.parse(document.getElementById('content').textContent);
const $ = name => document.getElementById(name);
const INK = '#222', QUIET = '#8a8a8a', PI = '#8a8a8a', ADAPTIVE = '#d55e00', FED = '#0072b2', BACK = '#009e73';
const MARK = 0.5, LIVE = 15, FADE = 2, SIZES = { d: 8, q: 8, '?': 1 };  // s; s; s; bytes
let code, memory, free = 0, blob = 0;  // compiled code, its memory, where free memory begins, where the numbers lie
const bytes = () => new Uint8Array(memory.buffer), view = () => new DataView(memory.buffer);
const doubles = (place, count) => new Float64Array(memory.buffer, place, count);
const product = shape => shape.reduce((a, b) => a * b, 1);

function allocate(size) {
  const place = free;
  free += (size + 15) & ~15;
  const missing = free - memory.buffer.byteLength;
  if (missing > 0) memory.grow((missing >> 16) + 1);
  return place;
}

/* One controller in the loop of one machine: arguments and result of the compiled run, in its memory. */
class Run {
  constructor(machine, which) {
    Object.assign(this, machine.images[which]);
    this.machine = machine; this.which = which; this.run = code[machine.runs[which]];
    this.place = allocate(this.size); this.result = allocate(this.size);
    this.named = {};
    for (const array of this.arrays) {
      const [, shape, kind, source, running, name] = array;
      array.own = running || typeof source !== 'number' ? allocate(product(shape) * SIZES[kind]) : blob + source;
      this.named[name] = { place: array.own, shape };
    }
  }
  series(name) {
    const { place, shape } = this.named[name];
    return doubles(place, product(shape));
  }
  put(offset, kind, value) {
    const at = this.place + offset;
    if (kind === 'd') view().setFloat64(at, value, true);
    else if (kind === 'q') view().setBigInt64(at, BigInt(value), true);
    else view().setUint8(at, value);
  }
  point(offset, place, shape) {
    view().setUint32(this.place + offset, place, true);
    shape.forEach((size, axis) => this.put(offset + 8 + 8 * axis, 'q', size));
  }
  /* Take the stops of the sliders; what a run changes only where it begins. */
  set(stops, begins) {
    this.machine.sliders.forEach((slider, k) => {
      const { numbers, arrays } = slider.changes[this.which];
      for (const [offset, kind, values, running] of numbers)
        if (begins || !running) this.put(offset, kind, values[stops[k]]);
      for (const [offset, places, running] of arrays) {
        const [shape, place] = places[stops[k]];
        if (!running) this.point(offset, blob + place, shape);
        else if (begins) this.refill(this.arrays.find(array => array[0] === offset), place);
      }
    });
  }
  refill([, shape, kind, , , name], place) {
    const size = product(shape) * SIZES[kind];
    if (place === null) bytes().fill(0, this.named[name].place, this.named[name].place + size);
    else bytes().copyWithin(this.named[name].place, blob + place, blob + place + size);
  }
  begin(stops) {
    bytes().copyWithin(this.place, blob + this.head, blob + this.head + this.size);
    for (const array of this.arrays) {
      if (array[4]) this.refill(array, array[3]);
      this.point(array[0], array.own, array[1]);
    }
    this.set(stops, true);
  }
  restart() {
    [0, 0, -1].forEach((value, k) => this.put(this.restartAt[k], 'q', value));
  }
  advance(stop) {
    this.put(this.stop, 'q', stop);
    this.run(this.place, this.result);
    for (const [from, to, size] of [this.state, this.position])
      bytes().copyWithin(this.place + to, this.result + from, this.result + from + size);
    if (this.deviations && stop % this.every === 0) this.deviations.set(this.series('7'), (stop / this.every - 1) * this.names);
  }
}

/* What is shown: machine, motion, stops of the sliders; and the two runs of it. */
const shown = { machine: 0, motion: '', stops: [], live: false, view: 0 };
let runs = [], samples = 0, ratio = 1, done = 0, began = 0;

const machine = () => content.machines[shown.machine];
const references = {};

function reference(motion) {
  if (!references[motion]) {
    const series = doubles(blob + content.references[motion].place, content.steps).slice();
    for (let k = 0; k < content.differences; k++) for (let i = 1; i < series.length; i++) series[i] += series[i - 1];
    references[motion] = series.map(value => value * 2 ** -content.fraction);
  }
  return references[motion];
}

function fill() {
  const { peak, sliders, solver_period: step } = machine(), unit = reference(shown.motion);
  const noise = sliders.map((slider, k) => slider.noise[shown.stops[k]]);
  const sigma = noise.find((value, k) => value !== sliders[k].noise[sliders[k].start]) ?? noise[0];
  for (const run of runs) {
    const full = run.series('2/reference'), drawn = run.series('2/noise');
    const rest = full.length - 1;
    for (let i = 0; i <= rest; i++) {
      const left = Math.min(1, (rest - i) * step / FADE);  // live, the motion ends at rest, and begins again
      full[i] = peak * unit[i] * (shown.live ? left * left * (3 - 2 * left) : 1);
    }
    const normal = doubles(blob + machine().noise, drawn.length);
    for (let k = 0; k < drawn.length; k++) drawn[k] = sigma * normal[k];
  }
}

function choose() {  // another machine: its two runs
  const own = machine();
  own.made ??= own.images.map((_, which) => {
    const run = new Run(own, which);
    run.restartAt = run.restart_places;
    run.every = Math.round(MARK / own.period);
    run.names = own.names.length;
    run.deviations = run.named['7'] && new Float64Array(run.names * Math.round(content.steps * own.solver_period / MARK));
    return run;
  });
  runs = own.made;
  samples = runs[0].named['5/torque'].shape[0];
  ratio = Math.round(own.period / own.solver_period);
}

function compute() {
  fill();
  for (const run of runs) {
    run.begin(shown.stops);
    if (!shown.live) for (let stop = run.every; stop <= samples; stop += run.every) run.advance(stop);
  }
  done = shown.live ? 0 : samples;
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b), half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

function rms(run, first, stop) {
  const planned = run.series('2/reference'), velocity = run.series('5/velocity'), size = planned.length - 1;
  let sum = 0;
  for (let i = first; i < stop; i++) {
    const at = i < 0 ? i + size : i;
    sum += (planned[at] - velocity[at]) ** 2;
  }
  return Math.sqrt(sum / (stop - first));
}

function figures() {
  const spans = content.references[shown.motion].spans, over = (first, stop) => runs.map(run => rms(run, first, stop));
  if (shown.live) {
    const stop = done * ratio, begun = Math.round(began / machine().period) * ratio;
    return { 'last 5 s': over(Math.max(stop - spans.window, stop - begun), Math.max(stop, 1)) };
  }
  const settled = Math.max(...machine().sliders.map((slider, k) => slider.settled[shown.stops[k]]));
  const windows = [];
  for (let first = 0; first + spans.window <= content.steps; first += spans.window)
    windows.push(over(first, first + spans.window));
  const least = content.least * median(windows.map(([pi]) => pi));
  const against = windows.map(([pi, own]) => [Math.max(pi, least), own]);
  const worst = against.reduce((a, b) => (b[1] / b[0] > a[1] / a[0] ? b : a));
  return { settled: over(settled, content.steps), 'first 5 s': over(...spans.start), 'worst window': worst };
}

const short = value => String(Number(value.toPrecision(3)));

function write() {
  const unit = `m${machine().units.velocity}`;
  $('unit').textContent = `rms error (${unit})`;
  $('figures').tBodies[0].innerHTML = Object.entries(figures()).map(([name, [pi, own]]) =>
    `<tr><th scope="row">${name}</th><td>${short(1e3 * pi)}</td><td>${short(1e3 * own)}</td>` +
    `<td>${(pi / own).toFixed(2)}</td></tr>`).join('');
}

/* Pictures. A line gives its value at a place; many places in one column of pixels are drawn as their extremes. */
function line(label, colour, step, get, look = {}) {
  return { label, colour, step, get, width: 1.5, ...look };
}

function panels() {
  const own = machine(), [pi, adaptive] = runs, size = content.steps - 1, step = own.solver_period;
  const fine = (run, name) => { const s = run.series(name); return i => s[i]; };
  const planned = fine(pi, '2/reference');
  const error = run => { const w = fine(run, '5/velocity'); return i => 1e3 * (planned(i) - w(i)); };
  const torque = fine(adaptive, '5/torque'), fed = fine(adaptive, '5/feedforward');
  const dash = { dash: [5, 4], width: 1.3 }, wide = { width: 2.2 };
  const found = [
    { title: `velocity (${own.units.velocity})`, lines: [
      line('PI', PI, step, fine(pi, '5/velocity'), wide), line('adaptive', ADAPTIVE, step, fine(adaptive, '5/velocity')),
      line('reference', '#000', step, planned, dash)] },
    { title: `error (m${own.units.velocity})`, lines: [
      line('PI', PI, step, error(pi), wide), line('adaptive', ADAPTIVE, step, error(adaptive))] },
    { title: `${own.torque} (${own.units.torque})`, lines: [
      line('PI', PI, own.period, fine(pi, '5/torque'), wide),
      line('adaptive', ADAPTIVE, own.period, torque),
      line('of it fed forward', FED, own.period, fed),
      line('of it feedback', BACK, own.period, i => torque(i) - fed(i)),
      line('true friction', '#000', own.period, fine(adaptive, '5/friction'), dash)] },
  ];
  const estimates = adaptive.series('5/estimates'), count = own.names.length;
  Object.entries(content.shown).forEach(([name, factor], k) => {
    const slider = own.sliders[k], place = own.names.indexOf(name), truth = slider.stops[shown.stops[k]];
    found.push({ title: `${slider.name} (${slider.unit})`, small: true, truth, lines: [
      line('estimate', ADAPTIVE, own.period, i => factor * estimates[i * count + place]),
      line('true', '#000', own.period, () => truth, dash)],
    band: t => 2 * factor * adaptive.deviations[Math.floor(t / MARK) * count + place] });
  });
  return found;
}

const now = () => Math.floor(began / machine().period) * machine().period;  // what has been run until, live

function span() {  // times that are shown, s
  const end = (content.steps - 1) * machine().solver_period;
  if (shown.live) return [now() - LIVE, now()];
  return [[0, end], [0, 10], [end - 10, end]][shown.view];
}

function ticks(low, high, most) {
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find(factor => factor * power >= raw), found = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

function paint(canvas, panel) {
  const scale = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * scale; canvas.height = height * scale;
  const pen = canvas.getContext('2d'), left = 46, right = width - 6, upper = 8, lower = height - 18;
  pen.scale(scale, scale); pen.font = '12px system-ui, sans-serif';
  const [from, to] = span(), length = (content.steps - 1) * machine().solver_period, columns = right - left;
  const start = shown.live ? Math.max(0, from) : from;
  const drawn = panel.lines.map(each => {  // smallest and largest value of each column
    const low = new Float64Array(columns + 1).fill(Infinity), high = new Float64Array(columns + 1).fill(-Infinity);
    const last = Math.round(length / each.step);
    for (let i = Math.ceil(start / each.step - 1e-6); i * each.step < to - 1e-6; i++) {
      const at = Math.floor((i * each.step - from) / (to - from) * columns), value = each.get(i % last);
      if (value < low[at]) low[at] = value;
      if (value > high[at]) high[at] = value;
    }
    return { each, low, high };
  });
  let least = Math.min(...drawn.map(({ low }) => Math.min(...low)));
  let most = Math.max(...drawn.map(({ high }) => Math.max(...high)));
  if (!(least <= most)) [least, most] = [0, 1];
  if (panel.small) [least, most] = [Math.min(0, least), Math.max(most, 1.25 * panel.truth, 1e-9)];
  const room = 0.05 * (most - least) || 1;
  [least, most] = [panel.small && least === 0 ? 0 : least - room, most + room];
  const x = t => left + (t - from) / (to - from) * columns, y = value => lower - (value - least) / (most - least) * (lower - upper);
  pen.strokeStyle = '#e6e6e6'; pen.fillStyle = '#5c5c5c'; pen.lineWidth = 1;
  pen.textAlign = 'right'; pen.textBaseline = 'middle';
  for (const value of ticks(least, most, panel.small ? 4 : 5)) {
    pen.beginPath(); pen.moveTo(left, y(value)); pen.lineTo(right, y(value)); pen.stroke();
    pen.fillText(String(value).replace('-', '−'), left - 5, y(value));
  }
  pen.textAlign = 'center'; pen.textBaseline = 'top';
  const times = ticks(Math.max(from, 0), Math.max(to, 1), Math.min(8, columns / 60));
  times.forEach((value, k) =>
    pen.fillText(k === times.length - 1 ? `${value} s` : value, Math.min(x(value), right - 10), lower + 4));
  pen.save(); pen.beginPath(); pen.rect(left, upper, columns, lower - upper); pen.clip();
  if (panel.band) {
    const { each, low } = drawn[0], sides = [[], []];
    for (let at = 0; at <= columns; at++) if (low[at] < Infinity) {
      const time = from + at / columns * (to - from), spread = panel.band(time % length);
      sides[0].push([left + at, y(low[at] + spread)]); sides[1].unshift([left + at, y(low[at] - spread)]);
    }
    pen.fillStyle = each.colour + '30'; pen.beginPath();
    for (const [px, py] of sides.flat()) pen.lineTo(px, Math.max(-1e4, Math.min(1e4, py)));
    pen.fill();
  }
  for (const { each, low, high } of drawn) {
    pen.strokeStyle = each.colour; pen.lineWidth = each.width; pen.setLineDash(each.dash ?? []); pen.lineJoin = 'round';
    pen.beginPath();
    let before = null;
    for (let at = 0; at <= columns; at++) if (low[at] < Infinity) {
      const up = before === null || Math.abs(low[at] - before) < Math.abs(high[at] - before);
      const [one, two] = up ? [low[at], high[at]] : [high[at], low[at]];
      pen.lineTo(left + at, y(one));
      if (two !== one) pen.lineTo(left + at, y(two));
      before = two;
    }
    pen.stroke();
  }
  pen.restore();
}

function lay(found) {  // figures with their legends, once for a machine
  const html = panel => `<figure><figcaption><b>${panel.title}</b>${panel.lines.map(each =>
    `<span><span class="key" style="color:${each.colour};border-top-style:${each.dash ? 'dashed' : 'solid'}"></span>${each.label}</span>`).join('')}` +
    `</figcaption><canvas role="img" aria-label="${panel.title} over time: ${panel.lines.map(each => each.label).join(', ')}"></canvas></figure>`;
  $('panels').innerHTML = found.filter(panel => !panel.small).map(html).join('');
  $('estimates').innerHTML = found.filter(panel => panel.small).map(html).join('');
}

function draw() {
  const found = panels(), canvases = document.querySelectorAll('canvas');
  found.forEach((panel, k) => paint(canvases[k], panel));
  write();
}

/* Scenario file and link. */
function scenario() {
  const { tables, motions, sliders } = machine(), whole = structuredClone({ ...tables, reference: motions[shown.motion] });
  sliders.forEach((slider, k) => {
    for (const [table, value] of Object.entries(slider.tables[shown.stops[k]]))
      whole[table] = Array.isArray(value) ? value : { ...whole[table], ...value };
  });
  const isTable = value => typeof value === 'object' && !Array.isArray(value);
  const fields = table => Object.entries(table).map(([key, value]) => `${key} = ${JSON.stringify(value)}\n`).join('');
  const rows = value => Array.isArray(value) && value.length > 0 && isTable(value[0]);
  const plain = Object.entries(whole).filter(([, value]) => !isTable(value) && !rows(value));
  let text = `# A ${machine().name} from the playground of adaptive-ff.\n\n${fields(Object.fromEntries(plain))}`;
  for (const [name, value] of Object.entries(whole)) {
    if (rows(value)) text += value.map(row => `\n[[${name}]]\n${fields(row)}`).join('');
    else if (isTable(value)) text += `\n[${name}]\n${fields(value)}`;
  }
  return text;
}

function link() {
  const words = new URLSearchParams({ machine: machine().name, motion: shown.motion });
  machine().sliders.forEach((slider, k) => {
    if (shown.stops[k] !== slider.start) words.set(slider.name, slider.stops[shown.stops[k]]);
  });
  return `#${words}`;
}

function follow() {  // take what the link carries; what it does not know stays as it is
  const words = new URLSearchParams(location.hash.slice(1));
  const named = content.machines.findIndex(each => each.name === words.get('machine'));
  shown.machine = Math.max(0, named);
  const motions = Object.keys(machine().motions);
  shown.motion = motions.includes(words.get('motion')) ? words.get('motion') : motions[0];
  shown.stops = machine().sliders.map(slider => {
    const value = words.has(slider.name) ? Number(words.get(slider.name)) : NaN;
    const far = slider.stops.map(stop => Math.abs(stop - value));
    return Number.isNaN(value) ? slider.start : far.indexOf(Math.min(...far));
  });
  order(2);
}

/* Coulomb friction is at most stiction: the one that is moved takes the other with it. Both have the same stops. */
function order(moved) {
  const [, coulomb, stiction] = shown.stops;
  if (coulomb > stiction) shown.stops[3 - moved] = shown.stops[moved];
}

/* Controls. */
function choices(name, values, current, pick) {
  const box = $(name), legend = box.querySelector('legend').outerHTML;
  box.innerHTML = legend + values.map((value, k) =>
    `<label><input type="radio" name="${name}" value="${k}" ${k === current ? 'checked' : ''}>${value}</label>`).join('');
  box.onchange = event => pick(Number(event.target.value));
}

function controls() {
  choices('machines', content.machines.map(each => each.name), shown.machine, k => {
    shown.machine = k; shown.stops = machine().sliders.map(slider => slider.start); rebuild();
  });
  const motions = Object.keys(machine().motions);
  choices('motions', motions, motions.indexOf(shown.motion), k => { shown.motion = motions[k]; began = 0; update(true); });
  $('sliders').innerHTML = machine().sliders.map((slider, k) =>
    `<div class="slider"><label for="s${k}">${slider.name}<output id="o${k}" for="s${k}"></output></label>` +
    `<input type="range" id="s${k}" min="0" max="${slider.stops.length - 1}" aria-describedby="d${k}"><small id="d${k}">${slider.says}</small></div>`).join('');
  machine().sliders.forEach((_, k) => {
    $(`s${k}`).oninput = event => { shown.stops[k] = Number(event.target.value); if (k === 1 || k === 2) order(k); update(false); };
  });
  $('views').innerHTML = ['whole run', 'first 10 s', 'last 10 s'].map((name, k) =>
    `<button data-view="${k}" aria-pressed="${k === shown.view}">${name}</button>`).join('');
  for (const button of $('views').children) button.onclick = () => {
    shown.view = Number(button.dataset.view);
    for (const each of $('views').children) each.setAttribute('aria-pressed', each === button);
    draw();
  };
}

function label() {
  machine().sliders.forEach((slider, k) => {
    const text = `${Number(slider.stops[shown.stops[k]].toPrecision(6))} ${slider.unit}`;
    $(`s${k}`).value = shown.stops[k]; $(`s${k}`).setAttribute('aria-valuetext', text); $(`o${k}`).value = text;
  });
  $('link').href = link();
  try { history.replaceState(null, '', link()); } catch { /* a page within a page may not */ }
}

let pending = 0;
function update(anew) {
  label();
  if (shown.live && !anew) { fill(); for (const run of runs) run.set(shown.stops, false); return; }
  cancelAnimationFrame(pending);
  pending = requestAnimationFrame(() => {
    const before = performance.now();
    compute(); draw();
    $('took').textContent = `Computed and drawn in ${Math.round(performance.now() - before)} ms.`;
    document.documentElement.dataset.drawn = Number(document.documentElement.dataset.drawn ?? 0) + 1;
  });
}

function rebuild() {
  choose(); controls(); began = 0; lay(panels()); update(true);
}

let clock = 0;
function tick(time) {
  if (!shown.live) return;
  began += Math.min(0.1, (time - clock) / 1e3);
  clock = time;
  const passed = Math.floor(began / machine().period) % samples;
  for (const run of runs) {
    let at = done;
    while (at !== passed) {
      if (at === samples) { run.restart(); at = 0; continue; }
      const next = Math.min(samples, (Math.floor(at / run.every) + 1) * run.every);
      at = passed > at ? Math.min(next, passed) : next;
      run.advance(at);
    }
  }
  done = passed;
  draw();
  requestAnimationFrame(tick);
}

function setLive(on) {
  shown.live = on; began = 0; clock = performance.now();
  $('live').setAttribute('aria-pressed', on);
  $('views').hidden = on;
  $('figures').setAttribute('aria-live', on ? 'off' : 'polite');
  update(true);
  if (on) requestAnimationFrame(() => requestAnimationFrame(tick));
}

async function start() {
  const packed = Uint8Array.from(atob($('packed').textContent), letter => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const all = new Uint8Array(await new Response(stream).arrayBuffer()), [length, size] = content.module;
  const { instance } = await WebAssembly.instantiate(all.slice(length, length + size), { env: Math });
  code = instance.exports; memory = code.memory;
  free = (code.__heap_base.value + 15) & ~15;
  blob = allocate(length);
  bytes().set(all.subarray(0, length), blob);
  follow(); rebuild();
  $('reset').onclick = () => { shown.stops = machine().sliders.map(slider => slider.start); update(false); };
  $('live').onclick = () => setLive(!shown.live);
  $('download').onclick = () => {
    const anchor = document.createElement('a');
    anchor.href = URL.createObjectURL(new Blob([scenario()], { type: 'application/toml' }));
    anchor.download = 'playground.toml'; anchor.click();
    setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
  };
  $('link').onclick = event => {
    event.preventDefault();
    navigator.clipboard?.writeText(location.href.split('#')[0] + link()).then(
      () => { $('link').textContent = 'Copied'; setTimeout(() => { $('link').textContent = 'Copy link'; }, 1500); }, () => {});
  };
  addEventListener('hashchange', () => { follow(); rebuild(); });
  new ResizeObserver(() => { if (!shown.live) draw(); }).observe($('panels'));
}

start();

// SPDX-License-Identifier: GPL-2.0-or-later
// The map of the report: inflates the frames of a field when it is asked for, draws them on a
// canvas, and moves through time with a slider, a button or the keyboard. Needs no library.
"use strict";
(() => {
  const player = document.getElementById("player");
  if (!player) return;
  const data = JSON.parse(document.getElementById("map-data").textContent);
  const find = (name) => player.querySelector(name);
  const canvas = find(".map canvas"), slider = find("input[type=range]");
  const when = find(".time output"), play = find(".play"), readout = find(".readout");
  const bar = find(".scale canvas"), tabs = [...player.querySelectorAll("[role=tab]")];
  const arrows = find(".arrows");
  const { rows, columns, times, extent } = data;
  const [left, right, bottom, top] = extent;
  const inflated = new Map();
  let layer = data.layers[0], frame = times.length - 1, frames = null, timer = 0;

  const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

  async function inflate(key, text) {
    if (!inflated.has(key)) {
      const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
      inflated.set(key, new Response(stream).arrayBuffer().then((found) => new Uint8Array(found)));
    }
    return inflated.get(key);
  }

  function say(value) {
    const size = Math.abs(value);
    return value.toLocaleString("en", { maximumFractionDigits: size >= 100 ? 0 : size >= 10 ? 1 : 2 });
  }

  function drawScale() {
    const palette = bytesOf(layer.palette), context = bar.getContext("2d");
    const image = context.createImageData(255, 1);
    for (let level = 0; level < 255; level++) {
      image.data.set([palette[3 * level], palette[3 * level + 1], palette[3 * level + 2], 255], 4 * level);
    }
    context.putImageData(image, 0, 0);
    find(".low").textContent = (layer.below ? "≤ " : "") + say(layer.low);
    find(".high").textContent = (layer.beyond ? "≥ " : "") + say(layer.high);
    find(".unit").textContent = layer.unit;
    find(".about").textContent = `${layer.text} (${layer.source})`;
    layer.colours = palette;
  }

  function drawFrame() {
    const context = canvas.getContext("2d"), image = context.createImageData(columns, rows);
    const start = frame * rows * columns;
    for (let cell = 0; cell < rows * columns; cell++) {
      const level = frames[start + cell];
      if (!level) continue;
      const place = 3 * (level - 1);
      image.data[4 * cell] = layer.colours[place];
      image.data[4 * cell + 1] = layer.colours[place + 1];
      image.data[4 * cell + 2] = layer.colours[place + 2];
      image.data[4 * cell + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    slider.value = frame;
    slider.setAttribute("aria-valuetext", times[frame]);
    when.textContent = times[frame];
    canvas.setAttribute("aria-label", `Map: ${layer.title}, ${times[frame]}. ${layer.text}`);
    player.dataset.frame = frame;
    player.dataset.field = layer.name;
    drawArrows();
  }

  async function drawArrows() {
    arrows.replaceChildren();
    if (layer.name !== "drift" || !data.arrows) return;
    const field = data.arrows, at = frame;
    const found = new Int8Array((await inflate("arrows", field.data)).buffer);
    if (layer.name !== "drift" || at !== frame) return;
    const boxes = field.rows * field.columns, all = boxes * times.length;
    const width = (right - left) / columns, height = (top - bottom) / rows;
    let path = "";
    for (let box = 0; box < boxes; box++) {
      const u = found[at * boxes + box] / 127, v = found[all + at * boxes + box] / 127;
      if (!u && !v) continue;
      const row = Math.floor(box / field.columns), column = box % field.columns;
      const x = left + (column + 0.5) * field.cells * width;
      const y = -top + ((row + 0.5) * field.cells - field.above) * height;
      const reach = 1.5 * field.cells * width;
      const dx = u * reach, dy = -v * reach;
      path += `M${x - dx / 2} ${y - dy / 2}l${dx} ${dy}`;
      path += `m${-0.32 * dx - 0.2 * dy} ${-0.32 * dy + 0.2 * dx}L${x + dx / 2} ${y + dy / 2}`;
      path += `l${-0.32 * dx + 0.2 * dy} ${-0.32 * dy - 0.2 * dx}`;
    }
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    line.setAttribute("d", path);
    arrows.replaceChildren(line);
  }

  async function choose(index, focus) {
    layer = data.layers[index];
    tabs.forEach((tab, place) => {
      tab.setAttribute("aria-selected", place === index);
      tab.tabIndex = place === index ? 0 : -1;
    });
    if (focus) tabs[index].focus();
    const wanted = layer, found = await inflate(layer.name, layer.data);
    if (wanted !== layer) return;
    frames = found;
    drawScale();
    drawFrame();
  }

  function show(next) {
    frame = Math.min(Math.max(next, 0), times.length - 1);
    if (frames) drawFrame();
  }

  function stop() {
    clearInterval(timer);
    timer = 0;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }

  function toggle() {
    if (timer) return stop();
    if (frame === times.length - 1) show(0);
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    // A run takes about twenty seconds, a short one a second each frame at most.
    timer = setInterval(() => {
      show(frame + 1);
      if (frame === times.length - 1) stop();
    }, Math.min(1000, Math.max(50, 20000 / times.length)));
  }

  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  play.addEventListener("click", toggle);
  tabs.forEach((tab, index) => {
    tab.addEventListener("click", () => choose(index, false));
    tab.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      choose((index + step + tabs.length) % tabs.length, true);
    });
  });
  const map = find(".map");
  map.addEventListener("pointermove", (event) => {
    if (!frames) return;
    const box = map.getBoundingClientRect();
    const across = (event.clientX - box.left) / box.width, down = (event.clientY - box.top) / box.height;
    const column = Math.floor(across * columns), row = Math.floor(down * rows);
    if (column < 0 || row < 0 || column >= columns || row >= rows) return;
    const level = frames[(frame * rows + row) * columns + column];
    const value = layer.low + ((level - 1) / 254) * (layer.high - layer.low);
    const more = level === 255 && layer.beyond ? "≥ " : level === 1 && layer.below ? "≤ " : "";
    readout.textContent = level ? `${more}${say(value)} ${layer.unit}` : layer.none;
  });
  map.addEventListener("pointerleave", () => { readout.textContent = ""; });

  if (!("DecompressionStream" in window)) {
    find(".about").textContent = "This browser is too old to draw the map (it has no DecompressionStream); the maps below show the end of the run.";
    return;
  }
  choose(0, false);
})();

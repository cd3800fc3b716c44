// SPDX-License-Identifier: BSD-3-Clause
// Shows the surface of the page by vtk.js. pages.py has written scene (JSON), data and library (deflated, base64).
"use strict";

const element = (id) => document.getElementById(id);

// Control points of the color maps, equidistant from 0 to 1.
const MAPS = {
  Viridis: ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"],
  "Cool to warm": ["#3b4cc0", "#6788ee", "#9abbff", "#c9d7f0", "#edd1c2", "#f7a889", "#e26952", "#b40426"],
  Plasma: ["#0d0887", "#4c02a1", "#7e03a8", "#aa2395", "#cc4778", "#e66c5c", "#f89540", "#fdc527", "#f0f921"],
  Gray: ["#202020", "#f8f8f8"],
};
// Axes that may point upwards.
const UPWARDS = { z: [0, 0, 1], y: [0, 1, 0], x: [1, 0, 0], "-z": [0, 0, -1], "-y": [0, -1, 0], "-x": [-1, 0, 0] };
// Colors of labels, in the order of their values.
const LABEL_COLORS = ["#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#76b7b2", "#edc948", "#b07aa1", "#9c755f", "#ff9da7", "#86bcb6",
  "#d37295", "#8cd17d", "#b6992d", "#499894", "#a0cbe8", "#ffbe7d"];
const SOLID = [0.78, 0.80, 0.84];
const MISSING_COLOR = [0.55, 0.55, 0.55];
const MISSING = 65535;
const LEVELS = 65534;

const hexToRgb = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);

async function inflated(id) {
  const text = atob(element(id).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) {
    bytes[k] = text.charCodeAt(k);
  }
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Numbers whose lowest bytes come first, then the next ones.
function numbers(bytes, offset, count, size) {
  const values = size === 1 ? new Uint8Array(count) : size === 2 ? new Uint16Array(count) : new Uint32Array(count);
  for (let plane = 0; plane < size; ++plane) {
    const start = offset + plane * count;
    for (let k = 0; k < count; ++k) {
      values[k] |= bytes[start + k] << (8 * plane);
    }
  }
  return values;
}

// Around the origin, with a longest side of 1: single precision shows surfaces of any size, however far from the origin.
function decodedPoints(scene, bytes) {
  const longest = Math.max(...scene.side);
  const count = scene.numberOfPoints;
  const codes = numbers(bytes, scene.points, 3 * count, 2);
  const points = new Float32Array(3 * count);
  for (let axis = 0; axis < 3; ++axis) {
    let code = 0;
    for (let k = 0; k < count; ++k) {
      code = (code + codes[axis * count + k]) & 65535;
      points[3 * k + axis] = (code / 65535 - 0.5) * (scene.side[axis] / longest);
    }
  }
  return points;
}

function decodedTriangles(scene, bytes) {
  const count = scene.numberOfTriangles;
  const codes = numbers(bytes, scene.triangles, 3 * count, 4);
  const signed = (code) => (code >>> 1) ^ -(code & 1);
  const triangles = new Uint32Array(3 * count);
  let first = 0;
  for (let k = 0; k < count; ++k) {
    first += signed(codes[k]);
    triangles[3 * k] = first;
    triangles[3 * k + 1] = first + signed(codes[count + k]);
    triangles[3 * k + 2] = first + signed(codes[2 * count + k]);
  }
  return triangles;
}

// Normals of points: the mean of those of their triangles, by area.
function normalsOf(points, triangles) {
  const normals = new Float32Array(points.length);
  for (let k = 0; k < triangles.length; k += 3) {
    const [a, b, c] = [3 * triangles[k], 3 * triangles[k + 1], 3 * triangles[k + 2]];
    const u = [0, 1, 2].map((x) => points[b + x] - points[a + x]);
    const v = [0, 1, 2].map((x) => points[c + x] - points[a + x]);
    for (let x = 0; x < 3; ++x) {
      const y = (x + 1) % 3;
      const z = (x + 2) % 3;
      const part = u[y] * v[z] - u[z] * v[y];
      normals[a + x] += part;
      normals[b + x] += part;
      normals[c + x] += part;
    }
  }
  for (let k = 0; k < normals.length; k += 3) {
    const length = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
    normals[k] /= length;
    normals[k + 1] /= length;
    normals[k + 2] /= length;
  }
  return normals;
}

// The values of a component of an array, or of the magnitude (component -1).
function valuesOf(scene, bytes, array, component) {
  const count = array.kind === "point" ? scene.numberOfPoints : scene.numberOfTriangles;
  const codes = numbers(bytes, array.data, count * array.components, array.form === "colors" ? 1 : 2);
  const value = (code) => {
    if (array.form === "labels") {
      return array.values[code];
    }
    const part = code / LEVELS;
    return code === MISSING ? NaN : array.lower * (1 - part) + array.upper * part;
  };
  const values = new Float64Array(count);
  for (let k = 0; k < count; ++k) {
    if (component >= 0) {
      values[k] = value(codes[component * count + k]);
    } else {
      let sum = 0;
      for (let c = 0; c < array.components; ++c) {
        sum += value(codes[c * count + k]) ** 2;
      }
      values[k] = Math.sqrt(sum);
    }
  }
  return values;
}

// Colors of an array of colors, three bytes each.
function colorsOf(scene, bytes, array) {
  const count = array.kind === "point" ? scene.numberOfPoints : scene.numberOfTriangles;
  const codes = numbers(bytes, array.data, count * array.components, 1);
  const colors = new Uint8Array(3 * count);
  for (let k = 0; k < count; ++k) {
    for (let c = 0; c < 3; ++c) {
      colors[3 * k + c] = codes[c * count + k];
    }
  }
  return colors;
}

function labelColor(array, value) {
  return hexToRgb(LABEL_COLORS[array.values.indexOf(value) % LABEL_COLORS.length]);
}

function extent(values) {
  let [lower, upper] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < lower) { lower = value; }
    if (value > upper) { upper = value; }
  }
  return lower <= upper ? [lower, upper] : [0, 0];
}

const shown = (value) => String(Number(value.toPrecision(4)));

class Viewer {
  constructor(scene, bytes) {
    this.scene = scene;
    this.bytes = bytes;
    const { vtkGenericRenderWindow } = vtk.Rendering.Misc;
    this.window = vtkGenericRenderWindow.newInstance({ background: [0.957, 0.961, 0.969] });
    this.window.setContainer(element("view"));
    this.window.resize();
    this.points = decodedPoints(scene, bytes);
    this.triangles = decodedTriangles(scene, bytes);
    this.build();
    window.addEventListener("resize", () => this.window.resize());
  }

  build() {
    const cells = new Uint32Array((this.triangles.length / 3) * 4);
    for (let k = 0, j = 0; k < this.triangles.length; k += 3, j += 4) {
      cells[j] = 3;
      cells.set(this.triangles.subarray(k, k + 3), j + 1);
    }
    this.surface = vtk.Common.DataModel.vtkPolyData.newInstance();
    this.surface.getPoints().setData(this.points, 3);
    this.surface.getPolys().setData(cells);
    this.surface.getPointData().setNormals(vtk.Common.Core.vtkDataArray.newInstance({
      name: "Normals", numberOfComponents: 3, values: normalsOf(this.points, this.triangles) }));
    this.mapper = vtk.Rendering.Core.vtkMapper.newInstance();
    this.mapper.setInputData(this.surface);
    this.actor = vtk.Rendering.Core.vtkActor.newInstance();
    this.actor.setMapper(this.mapper);
    this.actor.getProperty().setColor(...SOLID);
    this.actor.getProperty().setAmbient(0.15);
    this.actor.getProperty().setDiffuse(0.85);
    this.window.getRenderer().addActor(this.actor);
  }

  // Colors the surface: by values and a color map, or by the colors of labels, of arrays of colors and of missing values.
  color(array, component, map, range) {
    const lookup = vtk.Rendering.Core.vtkColorTransferFunction.newInstance();
    let [values, size] = [null, 1];
    let interpolate = false;
    if (array && array.form === "colors") {
      [values, size] = [colorsOf(this.scene, this.bytes, array), 3];
    } else if (array) {
      values = valuesOf(this.scene, this.bytes, array, component);
      const colors = MAPS[map].map(hexToRgb);
      colors.forEach((rgb, k) => lookup.addRGBPoint(range[0] + (k / (colors.length - 1)) * (range[1] - range[0]), ...rgb));
      const labels = array.form === "labels" && component >= 0;
      interpolate = !labels && array.kind === "point" && values.every((value) => !Number.isNaN(value));
      if (!interpolate) {
        [values, size] = [this.mapped(array, labels, values, lookup), 3];
      }
    }
    for (const data of [this.surface.getPointData(), this.surface.getCellData()]) {
      data.removeArray("Shown");
    }
    this.mapper.setScalarVisibility(values !== null);
    if (values) {
      const shownArray = vtk.Common.Core.vtkDataArray.newInstance({ name: "Shown", numberOfComponents: size,
        values: size === 1 ? Float32Array.from(values) : values });
      const data = array.kind === "point" ? this.surface.getPointData() : this.surface.getCellData();
      data.addArray(shownArray);
      this.mapper.setLookupTable(lookup);
      this.mapper.setScalarRange(...range);
      this.mapper.setUseLookupTableScalarRange(true);
      this.mapper.setInterpolateScalarsBeforeMapping(interpolate);
      this.mapper.setColorByArrayName("Shown");
      this.mapper[array.kind === "point" ? "setScalarModeToUsePointFieldData" : "setScalarModeToUseCellFieldData"]();
      this.mapper[size === 1 ? "setColorModeToMapScalars" : "setColorModeToDirectScalars"]();
    }
    this.surface.modified();
    this.render();
  }

  // Bytes of the colors of values.
  mapped(array, labels, values, lookup) {
    const colors = new Uint8Array(3 * values.length);
    const rgb = [0, 0, 0];
    for (let k = 0; k < values.length; ++k) {
      if (Number.isNaN(values[k])) {
        rgb.splice(0, 3, ...MISSING_COLOR);
      } else if (labels) {
        rgb.splice(0, 3, ...labelColor(array, values[k]));
      } else {
        lookup.getColor(values[k], rgb);
      }
      rgb.forEach((part, c) => { colors[3 * k + c] = Math.round(255 * part); });
    }
    return colors;
  }

  render() {
    this.window.getRenderWindow().render();
  }

  // The whole surface, slightly from above, with an axis upwards.
  reset() {
    const up = UPWARDS[element("up").value];
    const right = up[0] === 0 ? [1, 0, 0] : [0, 1, 0];
    const toward = [0, 1, 2].map((x) => right[(x + 1) % 3] * up[(x + 2) % 3] - right[(x + 2) % 3] * up[(x + 1) % 3]);
    const camera = this.window.getRenderer().getActiveCamera();
    camera.setFocalPoint(0, 0, 0);
    camera.setPosition(...[0, 1, 2].map((x) => 0.5 * right[x] + 0.35 * up[x] + toward[x]));
    camera.setViewUp(...up);
    this.window.getRenderer().resetCamera();
    camera.zoom(1.25);
    this.window.getRenderer().resetCameraClippingRange();
    this.render();
  }
}

// The panel. At first it shows what the address says after #: array=NAME&component=1&map=NAME&up=y.
class Panel {
  constructor(viewer) {
    this.viewer = viewer;
    this.scene = viewer.scene;
    element("title").textContent = this.scene.title;
    element("size").textContent = `${this.scene.numberOfPoints.toLocaleString("en")} points, `
      + `${this.scene.numberOfTriangles.toLocaleString("en")} triangles`;
    const names = this.scene.arrays.map((array) => array.name + (array.kind === "cell" ? " (cells)" : ""));
    this.fill("array", [["-1", "one color"], ...names.map((name, k) => [String(k), name])]);
    this.fill("map", Object.keys(MAPS).map((name) => [name, name]));
    this.fill("up", Object.keys(UPWARDS).map((name) => [name, name.replace("-", "\u2212")]));
    this.listen();
    this.fromAddress();
  }

  fill(id, options) {
    element(id).replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  }

  listen() {
    element("array").addEventListener("change", () => this.chooseArray());
    element("component").addEventListener("change", () => this.chooseComponent());
    element("map").addEventListener("change", () => this.update());
    for (const id of ["lower", "upper"]) {
      element(id).addEventListener("change", () => {
        this.range = [Number(element("lower").value), Number(element("upper").value)];
        this.update();
      });
    }
    element("smooth").addEventListener("change", (event) => {
      this.viewer.actor.getProperty()[event.target.checked ? "setInterpolationToGouraud" : "setInterpolationToFlat"]();
      this.viewer.render();
    });
    element("edges").addEventListener("change", (event) => {
      this.viewer.actor.getProperty().setEdgeVisibility(event.target.checked);
      this.viewer.render();
    });
    element("up").addEventListener("change", () => this.viewer.reset());
    element("reset").addEventListener("click", () => this.viewer.reset());
    window.addEventListener("hashchange", () => this.fromAddress());
  }

  fromAddress() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    const index = wanted.has("array") ? this.scene.arrays.findIndex((array) => array.name === wanted.get("array"))
      : this.scene.colorBy;
    element("array").value = String(index);
    if (MAPS[wanted.get("map")]) {
      element("map").value = wanted.get("map");
    }
    if (UPWARDS[wanted.get("up")] && wanted.get("up") !== element("up").value) {
      element("up").value = wanted.get("up");
      this.viewer.reset();
    }
    this.chooseArray(wanted.get("component"));
  }

  get array() {
    return this.scene.arrays[Number(element("array").value)];
  }

  chooseArray(component) {
    const { array } = this;
    const count = array && array.form !== "colors" ? array.components : 0;
    const axes = count <= 3 ? ["x", "y", "z"] : [];
    const options = [...Array(count).keys()].map((k) => [String(k), axes[k] || String(k)]);
    this.fill("component", count > 1 ? [["-1", "magnitude"], ...options] : options);
    element("componentLabel").hidden = count < 2;
    if (component !== null && component !== undefined && options.some(([value]) => value === component)) {
      element("component").value = component;
    }
    this.chooseComponent();
  }

  chooseComponent() {
    const { array } = this;
    this.range = [0, 1];
    if (array && array.form !== "colors") {
      this.range = extent(valuesOf(this.scene, this.viewer.bytes, array, this.component));
      [element("lower").value, element("upper").value] = this.range.map(shown);
    }
    this.update();
  }

  get component() {
    return Number(element("component").value);
  }

  update() {
    const { array } = this;
    const labels = Boolean(array) && array.form === "labels" && this.component >= 0;
    const continuous = Boolean(array) && array.form !== "colors" && !labels;
    element("mapLabel").hidden = element("rangeLabel").hidden = !continuous;
    let ends = this.range; // exact, unlike the rounded numbers that are shown
    if (!(ends[0] < ends[1])) {
      ends = [ends[0], ends[0] + (Math.abs(ends[0]) || 1) * 1e-6];
    }
    this.viewer.color(array, this.component, element("map").value, ends);
    this.showBar(array, labels, continuous, ends);
  }

  showBar(array, labels, continuous, ends) {
    const bar = element("bar");
    bar.hidden = !labels && !continuous;
    bar.replaceChildren();
    if (bar.hidden) {
      return;
    }
    const add = (parent, name, text = "") => {
      const child = document.createElement(name === "color" ? "i" : "div");
      child.className = name;
      child.textContent = text;
      parent.append(child);
      return child;
    };
    add(bar, "name", array.name);
    if (labels) {
      for (const value of array.values) {
        const row = add(bar, "label");
        add(row, "color").style.background = `rgb(${labelColor(array, value).map((part) => Math.round(255 * part)).join(" ")})`;
        row.append(String(value));
      }
      return;
    }
    const scale = add(bar, "scale");
    add(scale, "gradient").style.background = `linear-gradient(to top, ${MAPS[element("map").value].join(", ")})`;
    const ticks = add(scale, "ticks");
    for (let k = 4; k >= 0; --k) {
      add(ticks, "tick", shown(ends[0] + (k / 4) * (ends[1] - ends[0])));
    }
  }
}

function fail(text) {
  element("message").hidden = false;
  element("message").textContent = text;
  document.body.dataset.state = "failed";
}

async function start() {
  if (typeof DecompressionStream === "undefined") {
    fail("This page needs a browser of 2023 or later.");
    return;
  }
  const code = document.createElement("script");
  code.textContent = new TextDecoder().decode(await inflated("library"));
  document.head.append(code);
  const scene = JSON.parse(element("scene").textContent);
  const viewer = new Viewer(scene, await inflated("data"));
  element("panel").hidden = false;
  element("message").hidden = true;
  viewer.panel = new Panel(viewer);
  viewer.reset();
  window.viewer = viewer;
  document.body.dataset.points = String(viewer.points.length / 3);
  document.body.dataset.corners = String(viewer.triangles.reduce((sum, id) => sum + id, 0));
  document.body.dataset.extent = [0, 1, 2].map((axis) => extent(viewer.points.filter((_, k) => k % 3 === axis)).map(shown)).join(" ");
  document.body.dataset.range = viewer.panel.range.map(shown).join(" ");
  document.body.dataset.state = "ready";
}

start().catch((error) => fail(`The surface cannot be shown: ${error.message}`));

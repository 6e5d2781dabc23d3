"use strict";
// A viewer of states on curved elements. The numbers hold positions, displacements and fields at 4 x 4 points of each
// element; positions are polynomials of degree three in each direction, so they are exact in between.

const FIRST = 4;
const $ = (id) => document.getElementById(id);
const show = JSON.parse($("show").textContent);

async function unpacked() {
  const text = atob($("numbers").textContent.trim());
  const packed = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Values and slopes of the four cubics that are 1 at one of 0, 1/3, 2/3, 1: rows of points, columns of cubics. */
function cubics(k) {
  const nodes = [0, 1 / 3, 2 / 3, 1];
  const values = [], slopes = [];
  for (let i = 0; i <= k; i++) {
    const x = i / k;
    for (let a = 0; a < FIRST; a++) {
      let value = 1, slope = 0;
      for (let b = 0; b < FIRST; b++) {
        if (b === a) continue;
        const gap = nodes[a] - nodes[b];
        slope = slope * (x - nodes[b]) / gap + value / gap;
        value *= (x - nodes[b]) / gap;
      }
      values.push(value);
      slopes.push(slope);
    }
  }
  return { values, slopes };
}

/** (p x 4) times (4 x 4) times (4 x p) for one component of one element: values at a grid of p x p points. */
function spread(source, start, stride, across, up, p, target, offset, step) {
  const row = new Float64Array(FIRST * p);
  for (let j = 0; j < FIRST; j++)
    for (let i = 0; i < p; i++) {
      let sum = 0;
      for (let a = 0; a < FIRST; a++) sum += across[i * FIRST + a] * source[start + stride * (j * FIRST + a)];
      row[j * p + i] = sum;
    }
  for (let j = 0; j < p; j++)
    for (let i = 0; i < p; i++) {
      let sum = 0;
      for (let b = 0; b < FIRST; b++) sum += up[j * FIRST + b] * row[b * p + i];
      target[offset + step * (j * p + i)] = sum;
    }
}

/** Triangles, lines and buffers of one mesh, with k x k cells on each element. */
class Body {
  constructor(mesh, bytes, materials) {
    this.n = mesh.elements;
    this.k = Math.max(2, Math.min(12, Math.floor(Math.sqrt(12000 / this.n))));
    this.p = this.k + 1;
    this.each = this.p * this.p;
    this.cubics = cubics(this.k);
    this.at = new Float32Array(bytes, mesh.at, this.n * 48);
    this.places = new Float32Array(this.n * 48);
    const points = this.n * this.each;
    const surface = new THREE.BufferGeometry();
    this.position = new THREE.BufferAttribute(new Float32Array(3 * points), 3);
    this.normal = new THREE.BufferAttribute(new Float32Array(3 * points), 3);
    this.value = new THREE.BufferAttribute(new Float32Array(2 * points), 2);
    surface.setAttribute("position", this.position);
    surface.setAttribute("normal", this.normal);
    surface.setAttribute("uv", this.value);
    surface.setIndex(new THREE.BufferAttribute(this.triangles(), 1));
    const edges = new THREE.BufferGeometry();
    edges.setAttribute("position", this.position);
    const all = Array.from({ length: 4 * this.n }, (_, side) => side);
    edges.setIndex(new THREE.BufferAttribute(this.sides(all), 1));
    const ghost = new THREE.BufferGeometry();
    const rest = new Float32Array(3 * points);
    this.spreadAll(this.at, 3, rest);
    ghost.setAttribute("position", new THREE.BufferAttribute(rest, 3));
    ghost.setIndex(new THREE.BufferAttribute(this.sides(new Int32Array(bytes, mesh.rim, mesh.sides)), 1));
    this.surface = new THREE.Mesh(surface, materials.surface);
    this.edges = new THREE.LineSegments(edges, materials.edges);
    this.ghost = new THREE.LineSegments(ghost, materials.ghost);
    for (const part of [this.surface, this.edges, this.ghost]) part.frustumCulled = false;
    surface.boundingSphere = new THREE.Sphere(new THREE.Vector3(), Infinity);
  }

  triangles() {
    const { n, k, p, each } = this, out = new Uint32Array(6 * n * k * k);
    let at = 0;
    for (let e = 0; e < n; e++)
      for (let j = 0; j < k; j++)
        for (let i = 0; i < k; i++) {
          const a = e * each + j * p + i;
          out.set([a, a + 1, a + p + 1, a, a + p + 1, a + p], at);
          at += 6;
        }
    return out;
  }

  /** Segments along sides, each numbered 4 element + side, counter-clockwise from eta = 0. */
  sides(numbers) {
    const { k, p, each } = this, out = new Uint32Array(2 * k * numbers.length);
    const start = [0, k, p * k, 0], step = [1, p, 1, p];
    let at = 0;
    for (const number of numbers) {
      const side = number % 4, first = Math.floor(number / 4) * each + start[side];
      for (let i = 0; i < k; i++) {
        out[at++] = first + i * step[side];
        out[at++] = first + (i + 1) * step[side];
      }
    }
    return out;
  }

  spreadAll(source, parts, target, across = this.cubics.values, up = this.cubics.values) {
    for (let e = 0; e < this.n; e++)
      for (let c = 0; c < parts; c++)
        spread(source, e * 16 * parts + c, parts, across, up, this.p, target, e * this.each * parts + c, parts);
  }

  /** Put the surface where the undeformed one is, moved by a displacement times a factor. */
  move(displacement, factor) {
    const { places, at } = this;
    for (let i = 0; i < places.length; i++) places[i] = at[i] + factor * displacement[i];
    this.spreadAll(places, 3, this.position.array);
    const { values, slopes } = this.cubics, a = new Float32Array(this.position.array.length), b = new Float32Array(a.length);
    this.spreadAll(places, 3, a, slopes, values);
    this.spreadAll(places, 3, b, values, slopes);
    const normal = this.normal.array;
    for (let i = 0; i < a.length; i += 3) {
      const x = a[i + 1] * b[i + 2] - a[i + 2] * b[i + 1], y = a[i + 2] * b[i] - a[i] * b[i + 2],
            z = a[i] * b[i + 1] - a[i + 1] * b[i], size = Math.hypot(x, y, z) || 1;
      normal[i] = x / size;
      normal[i + 1] = y / size;
      normal[i + 2] = z / size;
    }
    this.position.needsUpdate = this.normal.needsUpdate = true;
  }

  /** Colour by values at 4 x 4 points, from low to high. */
  colour(values, low, high) {
    const fine = new Float32Array(this.n * this.each), uv = this.value.array;
    this.spreadAll(values, 1, fine);
    for (let i = 0; i < fine.length; i++) uv[2 * i] = (fine[i] - low) / (high - low);
    this.value.needsUpdate = true;
  }
}

/** The numbers of the show: displacements and fields of each state. */
class Numbers {
  constructor(bytes) {
    this.bytes = bytes;
  }

  displacement(state, phase) {
    const of = (k) => new Float32Array(this.bytes, show.states[k].displacement, show.meshes[show.states[k].mesh].elements * 48);
    return this.swung(of(state), show.rest === null ? null : of(show.rest), phase, false);
  }

  /** Values at 4 x 4 points of every element. */
  values(state, field, face, phase) {
    const vector = { displacement: -1, u1: 0, u2: 1, u3: 2 }[field.name];
    if (vector === undefined) {
      const of = (k) => {
        const n = show.meshes[show.states[k].mesh].elements * 16, [low, high] = field.stored[face];
        const whole = new Uint16Array(this.bytes, show.states[k].values[`${field.name} ${face}`], n);
        return Float32Array.from(whole, (q) => low + (q / 65535) * (high - low));
      };
      return this.swung(of(state), show.rest === null ? null : of(show.rest), phase, !field.signed);
    }
    const u = this.displacement(state, phase), out = new Float32Array(u.length / 3);
    for (let i = 0; i < out.length; i++)
      out[i] = vector < 0 ? Math.hypot(u[3 * i], u[3 * i + 1], u[3 * i + 2]) : u[3 * i + vector];
    return out;
  }

  /** A mode's values at a phase: those at rest, and the sine of the phase times the rest. */
  swung(values, rest, phase, positive) {
    if (!show.swings) return values;
    const part = Math.sin((phase * Math.PI) / 180);
    return values.map((value, i) => {
      const at = rest === null ? 0 : rest[i], out = at + part * (value - at);
      return positive ? Math.abs(out) : out;
    });
  }
}

const look = { ...show.look, phase: 90 };
const field = () => show.fields.find((each) => each.name === look.field);
const faceOf = (of) => (of.faces ? look.face : "");
const limits = () => {
  const every = field().limits[faceOf(field())];
  return every[show.swings ? look.state : 0];
};
const shown = (number, factor = 1) => {
  const value = number * factor;
  return (Math.abs(value) < 1e-12 * Math.max(...limits().map(Math.abs)) * factor ? 0 : Number(value.toPrecision(3)))
    .toString().replace("-", "\u2212");
};

class Page {
  constructor(bytes) {
    this.numbers = new Numbers(bytes);
    this.canvas = $("canvas");
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.scene = new THREE.Scene();
    this.camera = new THREE.OrthographicCamera();
    this.materials = this.makeMaterials();
    this.bodies = show.meshes.map((mesh) => new Body(mesh, bytes, this.materials));
    for (const body of this.bodies) this.scene.add(body.surface, body.edges, body.ghost);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.ask());
    this.controls.zoomToCursor = true;
    this.controls.enableDamping = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.fillControls();
    this.reset();
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.dress());
    this.canvas.addEventListener("pointermove", (event) => this.read(event));
    this.canvas.addEventListener("pointerdown", (event) => this.read(event));
    this.canvas.addEventListener("pointerleave", () => ($("readout").textContent = ""));
    this.dress();
    this.update();
  }

  makeMaterials() {
    this.map = new THREE.DataTexture(new Uint8Array(4 * 256), 256, 1);
    this.map.magFilter = this.map.minFilter = THREE.LinearFilter;
    const surface = new THREE.ShaderMaterial({
      side: THREE.DoubleSide,
      uniforms: { map: { value: this.map } },
      vertexShader: `varying vec3 n; varying float t;
        void main() { n = normalMatrix * normal; t = uv.x; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }`,
      // As bright as the colour bar where the surface faces the eye; the light is a little to the upper left of it.
      fragmentShader: `uniform sampler2D map; varying vec3 n; varying float t;
        void main() {
          vec3 m = normalize(n); m = m.z < 0.0 ? -m : m;
          float light = 0.74 + 0.20 * m.z + 0.12 * max(dot(m, normalize(vec3(-0.5, 0.7, 0.6))), 0.0);
          vec3 colour = texture2D(map, vec2((clamp(t, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
          gl_FragColor = vec4(colour * min(light, 1.0), 1.0);
        }`,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2,
    });
    return { surface, edges: new THREE.LineBasicMaterial(), ghost: new THREE.LineBasicMaterial() };
  }

  /** Colours of lines as the page's. */
  dress() {
    const style = getComputedStyle(document.documentElement);
    this.materials.edges.color.setStyle(style.getPropertyValue("--edge").trim());
    this.materials.ghost.color.setStyle(style.getPropertyValue("--ghost").trim());
    this.ask();
  }

  reset() {
    const [right, up, back] = show.axes.map((axis) => new THREE.Vector3(...axis));
    const middle = [0, 1, 2].map((i) => (show.low[i] + show.high[i]) / 2);
    const size = Math.hypot(...[0, 1, 2].map((i) => show.high[i] - show.low[i])) || 1;
    const target = new THREE.Vector3().addScaledVector(right, middle[0]).addScaledVector(up, middle[1]).addScaledVector(back, middle[2]);
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(back, 20 * size);
    this.camera.near = 0.1 * size;
    this.camera.far = 40 * size;
    this.camera.zoom = 1;
    this.resize();
    this.controls.update();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    const half = 0.55 * Math.max(show.high[1] - show.low[1], (show.high[0] - show.low[0]) * (height / width)) || 1;
    this.camera.top = half;
    this.camera.bottom = -half;
    this.camera.right = (half * width) / height;
    this.camera.left = -this.camera.right;
    this.camera.updateProjectionMatrix();
    this.ask();
  }

  /** Draw before the screen is next renewed. */
  ask() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      if (this.controls.update()) this.ask();
      this.renderer.render(this.scene, this.camera);
      this.drawAxes();
    });
  }

  drawAxes() {
    const e = this.camera.matrixWorldInverse.elements, colours = ["#d55e00", "#009e73", "#3f8fd0"];
    $("axes").innerHTML = ["x", "y", "z"].map((name, i) => {
      const x = 24 * e[4 * i], y = -24 * e[4 * i + 1];
      return `<line x1="0" y1="0" x2="${x}" y2="${y}" stroke="${colours[i]}"/><text x="${1.4 * x}" y="${1.4 * y}">${name}</text>`;
    }).join("");
  }

  fillControls() {
    const option = (value, text) => Object.assign(document.createElement("option"), { value, textContent: text });
    $("field").append(...show.fields.map((each) => option(each.name, each.words)));
    $("face").append(...show.faces.map((face) => option(face, face === "middle" ? "middle" : `${face} face`)));
    $("state").max = show.names.length - 1;
    $("state-box").hidden = show.names.length < 2;
    $("phase-box").hidden = !show.swings;
    $("play").hidden = show.swings;
    $("scale").max = Math.max(2 * look.scale, 2);
    for (const name of ["state", "phase", "field", "face", "scale"])
      $(name).addEventListener("input", (event) => {
        const value = event.target.value;
        this.change({ [name]: ["field", "face"].includes(name) ? value : Number(value) });
      });
    for (const name of ["mesh", "undeformed"])
      $(name).addEventListener("change", (event) => this.change({ [name]: event.target.checked }));
    $("reset").addEventListener("click", () => { this.change({ scale: show.look.scale }); this.reset(); });
    for (const name of ["play", "swing"]) $(name).addEventListener("click", () => this.play(!this.playing));
  }

  play(on) {
    this.playing = on;
    for (const name of ["play", "swing"]) {
      $(name).textContent = on ? "Pause" : "Play";
      $(name).setAttribute("aria-pressed", on);
    }
    let before = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      if (show.swings) this.change({ phase: (look.phase + ((now - before) / 2000) * 360) % 360 });
      else if (now - before >= 1000 * show.seconds) this.change({ state: (look.state + 1) % show.names.length });
      else return requestAnimationFrame(step);
      before = now;
      requestAnimationFrame(step);
    };
    if (on) requestAnimationFrame(step);
  }

  change(what) {
    Object.assign(look, what);
    this.update();
  }

  update() {
    const of = field(), [low, high] = limits(), mesh = show.states[look.state].mesh;
    this.bodies.forEach((body, k) => {
      body.surface.visible = k === mesh;
      body.edges.visible = k === mesh && look.mesh;
      body.ghost.visible = k === mesh && look.undeformed;
    });
    this.bodies[mesh].move(this.numbers.displacement(look.state, look.phase), look.scale);
    this.bodies[mesh].colour(this.numbers.values(look.state, of, faceOf(of), look.phase), low, high);
    this.describe(of, low, high);
    $("readout").textContent = "";
    this.ask();
  }

  describe(of, low, high) {
    const map = show.maps[low < 0 && high > 0 && Math.min(-low, high) > 0.05 * Math.max(-low, high) ? "two" : "one"];
    const colours = map.match(/.{6}/g);
    this.map.image.data.set(colours.flatMap((c) => [0, 2, 4].map((i) => parseInt(c.slice(i, i + 2), 16)).concat(255)));
    this.map.needsUpdate = true;
    const narrow = window.matchMedia("(max-width: 620px)").matches;
    const stops = colours.filter((_, i) => i % 15 === 0).map((c) => `#${c}`).join(",");
    $("gradient").style.background = `linear-gradient(to ${narrow ? "right" : "top"}, ${stops})`;
    $("ticks").replaceChildren(...[0, 1, 2, 3, 4, 5, 6].map((i) => Object.assign(document.createElement("li"),
      { textContent: shown(low + (i / 6) * (high - low), of.factor) })));
    const where = of.faces ? (look.face === "middle" ? "middle" : `${look.face} face`) : "";
    const words = where ? `${of.words}, ${where}` : of.words;
    $("bar-title").textContent = `${of.short}${of.unit ? ` (${of.unit})` : ""}`;
    const name = show.names[look.state], state = [name, show.notes[look.state]].filter(Boolean).join(", ");
    $("title").textContent = show.title || words;
    $("subtitle").textContent = [show.title ? words : "", state].filter(Boolean).join(" \u00b7 ");
    $("state-name").textContent = name;
    $("phase-name").textContent = `${Math.round(look.phase)}\u00b0`;
    $("scale-name").textContent = `\u00d7 ${Number(look.scale.toPrecision(3))}`;
    for (const each of ["state", "phase", "field", "face", "scale"]) $(each).value = look[each];
    for (const each of ["mesh", "undeformed"]) $(each).checked = look[each];
    $("face").disabled = !of.faces;
    const range = `${shown(low, of.factor)} to ${shown(high, of.factor)} ${of.unit}`;
    this.canvas.setAttribute("aria-label", `${[show.title, words, state].filter(Boolean).join(", ")}; colours from ${range}`);
    document.querySelector(".bar").setAttribute("aria-label", `colour bar, ${range}`);
  }

  /** The value under the pointer. */
  read(event) {
    if (event.buttons && event.type === "pointermove") return;
    const box = this.canvas.getBoundingClientRect(), of = field(), [low, high] = limits();
    const at = new THREE.Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const [hit] = ray.intersectObject(this.bodies[show.states[look.state].mesh].surface);
    $("readout").textContent = hit ? `${of.short} = ${shown(low + hit.uv.x * (high - low), of.factor)} ${of.unit}` : "";
  }
}

unpacked().then((bytes) => { window.page = new Page(bytes); document.documentElement.dataset.ready = "true"; }).catch((error) => {
  $("trouble").hidden = false;
  $("trouble").textContent = `This browser cannot draw the body (${error.message}); it needs WebGL 2.`;
});

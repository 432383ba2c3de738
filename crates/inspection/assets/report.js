"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const read = (id) => JSON.parse($(id).textContent);
  const scene = read("scene"), report = read("report");
  const bytes = (id) => {
    const text = atob($(id).textContent.trim()), out = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) out[i] = text.charCodeAt(i);
    return out.buffer;
  };
  const view = $("view"), tip = $("tip"), ring = $("ring");
  const number = (x) => (Number.isFinite(x) ? String(Number(x.toPrecision(6))) : "not measured");

  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  } catch (error) {
    $("nogl").style.display = "block";
    document.body.dataset.ready = "no-webgl";
    return;
  }
  view.prepend(renderer.domElement);
  renderer.domElement.setAttribute("role", "img");
  renderer.domElement.setAttribute("aria-label", view.dataset.label);

  // Positions are 16-bit shares of a cube; the camera works in its units, centred.
  const deviations = new Float32Array(bytes("deviations"));
  const count = deviations.length;
  const stop = (c) => new THREE.Vector3(c[0] / 255, c[1] / 255, c[2] / 255);
  const uniforms = {
    limits: { value: new THREE.Vector3(scene.lower, scene.target, scene.upper) },
    stops: { value: scene.stops.map(stop) },
    edge: { value: scene.edge },
    size: { value: 4 }, bias: { value: 0 }, onlyOut: { value: 0 }, bands: { value: 0 },
  };
  const pointVertex = (colour) => `
    uniform vec3 limits; uniform vec3 stops[7]; uniform float edge, size, bias, onlyOut, bands;
    attribute float deviation; varying vec4 shade; varying float rim;
    vec3 diverging(float place) {
      float at = (0.5 + 0.5 * clamp(place, -1.0, 1.0)) * 6.0;
      int below = int(min(floor(at), 5.0));
      return mix(stops[below], stops[below + 1], at - float(below));
    }
    void main() {
      bool measured = deviation == deviation && abs(deviation) < 3e38;
      bool over = deviation > limits.z, under = deviation < limits.x;
      float side = deviation >= limits.y ? limits.z - limits.y : limits.y - limits.x;
      float share = deviation == limits.y ? 0.0 : clamp((deviation - limits.y) / side, -1.0, 1.0);
      if (bands > 0.5) share = sign(share) * (min(floor(abs(share) * 4.0), 3.0) + 0.5) / 4.0;
      float place = over ? 1.0 : under ? -1.0 : edge * share;
      bool isOut = measured && (over || under);
      rim = isOut && size > 5.0 ? 1.0 : 0.0;
      ${colour}
      vec4 eye = modelViewMatrix * vec4(position - 0.5, 1.0);
      gl_Position = projectionMatrix * eye;
      gl_Position.z = (projectionMatrix * (eye + vec4(0.0, 0.0, bias, 0.0))).z;
      gl_PointSize = (isOut ? 1.25 : 1.0) * size;
      if (onlyOut > 0.5 && !isOut) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    }`;
  const pointFragment = (rimmed) => `
    varying vec4 shade; varying float rim;
    void main() {
      vec2 at = gl_PointCoord - 0.5; float r = length(at);
      if (r > 0.5) discard;
      gl_FragColor = ${rimmed ? "rim > 0.5 && r > 0.36 ? vec4(0.0, 0.0, 0.0, 1.0) : shade" : "shade"};
    }`;
  const pointMaterial = (colour, rimmed) => new THREE.ShaderMaterial({
    uniforms, blending: THREE.NoBlending, vertexShader: pointVertex(colour), fragmentShader: pointFragment(rimmed),
  });
  const shown = pointMaterial("shade = vec4(measured ? diverging(place) : vec3(0.59), 1.0);", true);
  const picked = pointMaterial("int id = gl_VertexID + 1; shade = vec4(ivec4(id, id >> 8, id >> 16, id >> 24) & 255) / 255.0; rim = 0.0;", false);
  const cloud = new THREE.BufferGeometry();
  const positions = new Uint16Array(bytes("points"));
  cloud.setAttribute("position", new THREE.BufferAttribute(positions, 3, true));
  cloud.setAttribute("deviation", new THREE.BufferAttribute(deviations, 1));
  const points = new THREE.Points(cloud, shown);
  points.frustumCulled = false;

  const surface = new THREE.BufferGeometry();
  surface.setAttribute("position", new THREE.BufferAttribute(new Uint16Array(bytes("vertices")), 3, true));
  surface.setAttribute("normal", new THREE.BufferAttribute(new Int8Array(bytes("normals")), 3, true));
  surface.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes("triangles")), 1));
  const surfaceMaterial = (body) => new THREE.ShaderMaterial({
    side: THREE.DoubleSide, blending: THREE.NoBlending, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    vertexShader: "varying vec3 n; void main() { n = normalMatrix * normal; gl_Position = projectionMatrix * modelViewMatrix * vec4(position - 0.5, 1.0); }",
    fragmentShader: `varying vec3 n; void main() { ${body} }`,
  });
  const grey = surfaceMaterial("float l = abs(normalize(n + vec3(0.0, 0.0, 1e-6)).z); gl_FragColor = vec4(vec3(0.52, 0.55, 0.58) + 0.36 * l, 1.0);");
  const nothing = surfaceMaterial("gl_FragColor = vec4(0.0);");
  const model = new THREE.Mesh(surface, grey);
  model.frustumCulled = false;
  const world = new THREE.Scene();
  world.add(model, points);
  // The edges of a CAD model, in front of the faces by a hair.
  let edges = null;
  if (scene.lines) {
    const ends = new THREE.BufferGeometry();
    ends.setAttribute("position", new THREE.BufferAttribute(new Uint16Array(bytes("lines")), 3, true));
    edges = new THREE.LineSegments(ends, new THREE.ShaderMaterial({
      blending: THREE.NoBlending,
      vertexShader: "void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position - 0.5, 1.0); gl_Position.z -= 2e-5 * gl_Position.w; }",
      fragmentShader: "void main() { gl_FragColor = vec4(0.2, 0.22, 0.25, 1.0); }",
    }));
    edges.frustumCulled = false;
    world.add(edges);
  }

  const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -20, 20);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  controls.zoomToCursor = true;
  controls.enableDamping = false;
  controls.minZoom = 0.05; controls.maxZoom = 5000;
  const box = { low: new THREE.Vector3(...scene.low), high: new THREE.Vector3(...scene.high) };
  const centre = box.low.clone().add(box.high).multiplyScalar(0.5).subScalar(0.5);
  const extent = box.high.clone().sub(box.low);
  const radius = Math.max(extent.length() / 2, 1e-6);

  const corners = [...Array(8).keys()].map((k) => new THREE.Vector3(
    (k & 1 ? box.high : box.low).x, (k & 2 ? box.high : box.low).y, (k & 4 ? box.high : box.low).z).subScalar(0.5));
  const look = (direction, up) => {
    camera.up.set(...up);
    controls.target.copy(centre);
    camera.position.copy(centre).add(new THREE.Vector3(...direction).normalize().multiplyScalar(4 * radius));
    camera.lookAt(centre);
    camera.updateMatrixWorld();
    // As large as the box allows from here.
    let wide = 1e-9, high = 1e-9;
    for (const corner of corners) {
      const at = corner.clone().applyMatrix4(camera.matrixWorldInverse);
      wide = Math.max(wide, Math.abs(at.x)); high = Math.max(high, Math.abs(at.y));
    }
    const aspect = view.clientWidth / view.clientHeight;
    camera.zoom = 0.92 * Math.min(aspect / wide, 1 / high);
    base = camera.zoom;
    controls.update();
    draw();
  };
  let base = 1, marked = null, scheduled = false;
  const resize = () => {
    const [w, h] = [view.clientWidth, view.clientHeight];
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(w, h, false);
    camera.left = -w / h; camera.right = w / h;
    draw();
  };
  const pixelSize = () => {
    const own = Math.sqrt(0.5 * view.clientWidth * view.clientHeight / Math.max(count, 1));
    const zoomed = Math.min(Math.max(own, 2.2), 9) * Math.pow(Math.max(camera.zoom / base, 1), 0.6);
    return Math.min(zoomed, 28) * Number($("size").value) * renderer.getPixelRatio();
  };
  const place = (element, at) => {
    const p = at.clone().project(camera);
    element.style.left = `${(p.x + 1) / 2 * view.clientWidth}px`;
    element.style.top = `${(1 - p.y) / 2 * view.clientHeight}px`;
    element.style.display = "block";
  };
  const drawNow = () => {
    scheduled = false;
    camera.updateProjectionMatrix();
    uniforms.size.value = pixelSize();
    renderer.render(world, camera);
    if (marked) place(ring, marked); else ring.style.display = "none";
    drawAxes();
  };
  const draw = () => { if (!scheduled) { scheduled = true; requestAnimationFrame(drawNow); } };
  const drawAxes = () => {
    const line = (v, name, colour) => {
      const p = v.clone().transformDirection(camera.matrixWorldInverse);
      const [x, y] = [37 + 24 * p.x, 37 - 24 * p.y];
      return `<line x1="37" y1="37" x2="${x}" y2="${y}" stroke="${colour}" stroke-width="2"/><text x="${37 + 32 * p.x}" y="${41 - 32 * p.y}" text-anchor="middle">${name}</text>`;
    };
    $("axes").innerHTML = line(new THREE.Vector3(1, 0, 0), "X", "#c2410c") + line(new THREE.Vector3(0, 1, 0), "Y", "#4d5b1f") + line(new THREE.Vector3(0, 0, 1), "Z", "#1d4ed8");
  };
  uniforms.bias.value = Math.min(0.02 * radius, 3 * Math.max(Math.abs(scene.lower), Math.abs(scene.upper)) / scene.side + 1e-3 * radius);
  controls.addEventListener("change", draw);
  window.addEventListener("resize", resize);

  // The point under the pointer: numbers instead of colours, drawn into a few pixels around it.
  const REACH = 13;
  const target = new THREE.WebGLRenderTarget(REACH, REACH, { type: THREE.UnsignedByteType });
  const pixels = new Uint8Array(REACH * REACH * 4);
  const pick = (x, y) => {
    const ratio = renderer.getPixelRatio();
    const half = (REACH - 1) / 2;
    camera.setViewOffset(view.clientWidth * ratio, view.clientHeight * ratio, x * ratio - half, y * ratio - half, REACH, REACH);
    points.material = picked; model.material = nothing;
    if (edges) edges.visible = false;
    renderer.setRenderTarget(target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(world, camera);
    renderer.readRenderTargetPixels(target, 0, 0, REACH, REACH, pixels);
    renderer.setRenderTarget(null);
    points.material = shown; model.material = grey;
    if (edges) edges.visible = model.visible;
    camera.clearViewOffset();
    let best = -1, nearest = Infinity;
    for (let j = 0; j < REACH; j++) for (let i = 0; i < REACH; i++) {
      const k = 4 * (j * REACH + i);
      const id = (pixels[k] | pixels[k + 1] << 8 | pixels[k + 2] << 16 | pixels[k + 3] << 24) >>> 0;
      const far = (i - half) ** 2 + (j - half) ** 2;
      if (id > 0 && id <= count && far < nearest) { nearest = far; best = id - 1; }
    }
    return best;
  };
  const fileIndex = (i) => (scene.indices ? indices[i] : i * scene.stride);
  const indices = scene.indices ? new Uint32Array(bytes("indices")) : null;
  const state = (d) => (!Number.isFinite(d) ? "" : d > scene.upper ? "above the tolerance" : d < scene.lower ? "below the tolerance" : "within the tolerance");
  const positionOf = (i) => [0, 1, 2].map((axis) => scene.origin[axis] + scene.side * positions[3 * i + axis] / 65535);
  const describe = (i) => `${number(deviations[i])}   ${state(deviations[i])}\npoint ${fileIndex(i)}\nx ${number(positionOf(i)[0])}   y ${number(positionOf(i)[1])}   z ${number(positionOf(i)[2])}`;
  let hover = null;
  renderer.domElement.addEventListener("pointermove", (event) => {
    if (event.buttons) { tip.style.display = "none"; return; }
    const frame = view.getBoundingClientRect();
    const at = [event.clientX - frame.left, event.clientY - frame.top];
    if (hover === null) requestAnimationFrame(() => {
      const [x, y] = hover; hover = null;
      const i = pick(x, y);
      if (i < 0) { tip.style.display = "none"; return; }
      tip.textContent = describe(i);
      tip.style.display = "block";
      tip.style.left = `${Math.min(x + 16, view.clientWidth - tip.offsetWidth - 4)}px`;
      tip.style.top = `${Math.max(y - tip.offsetHeight - 10, 4)}px`;
    });
    hover = at;
  });
  renderer.domElement.addEventListener("pointerleave", () => { tip.style.display = "none"; });

  const inView = (p) => new THREE.Vector3(...[0, 1, 2].map((axis) => (p[axis] - scene.origin[axis]) / scene.side - 0.5));
  const show = (worst) => {
    marked = inView(worst.point);
    const out = marked.clone().sub(inView(worst.foot)).multiplyScalar(Math.sign(worst.distance) || 1);
    const direction = out.length() > 1e-12 ? out.normalize() : marked.clone().sub(centre).normalize();
    const side = Math.abs(direction.dot(camera.up)) > 0.95 ? 0.35 : 0;
    camera.position.copy(marked).addScaledVector(direction.add(new THREE.Vector3(side, 0.2, 0.15)).normalize(), 4 * radius);
    controls.target.copy(marked);
    camera.zoom = Math.max(camera.zoom, 5 * base);
    controls.update();
    draw();
    view.scrollIntoView({ block: "nearest" });
  };
  for (const button of document.querySelectorAll("[data-worst]"))
    button.addEventListener("click", () => show(report.worst[Number(button.dataset.worst)]));
  const views = { iso: [[1, -1.25, 0.8], [0, 0, 1]], front: [[0, -1, 0], [0, 0, 1]], back: [[0, 1, 0], [0, 0, 1]], right: [[1, 0, 0], [0, 0, 1]],
    left: [[-1, 0, 0], [0, 0, 1]], top: [[0, 0, 1], [0, 1, 0]], bottom: [[0, 0, -1], [0, 1, 0]] };
  for (const button of document.querySelectorAll("[data-view]"))
    button.addEventListener("click", () => { marked = null; look(...views[button.dataset.view]); });
  $("model").addEventListener("change", (event) => { model.visible = event.target.checked; if (edges) edges.visible = model.visible; draw(); });
  $("out").addEventListener("change", (event) => { uniforms.onlyOut.value = Number(event.target.checked); draw(); });
  $("bands").addEventListener("change", (event) => { uniforms.bands.value = Number(event.target.checked); draw(); });
  $("size").addEventListener("input", draw);

  window.inspection = { pick, describe, show: (k) => show(report.worst[k]), count, project: (i) => {
    const p = new THREE.Vector3(positions[3 * i] / 65535 - 0.5, positions[3 * i + 1] / 65535 - 0.5, positions[3 * i + 2] / 65535 - 0.5).project(camera);
    return [(p.x + 1) / 2 * view.clientWidth, (1 - p.y) / 2 * view.clientHeight];
  }, drawNow, canvas: renderer.domElement };
  resize();
  look(...views.iso);
  drawNow();
  document.body.dataset.ready = "yes";
})();

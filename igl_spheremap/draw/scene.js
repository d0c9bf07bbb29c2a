// Surfaces side by side that turn together under the mouse. Spheres are drawn after a Moebius map that magnifies
// what is in front: conformal, as the map itself. Folded faces that colour too few pixels have a dot, those that lie
// behind a ring.
{  // each scene of a page brings this script
const MARK = 4;  // pixels, the radius of dots and rings
for (const element of document.querySelectorAll("[data-scene]:empty")) {
  const scene = JSON.parse(element.dataset.scene);
  const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
  const faces = new Uint32Array(bytes(scene.faces));
  let turn = [1, 0, 0, 0, 1, 0, 0, 0, 1], power = 1, zoom = 1;
  const turned = (x, k) => [0, 3, 6].map(row => turn[row] * x[3 * k] + turn[row + 1] * x[3 * k + 1] + turn[row + 2] * x[3 * k + 2]);
  // Where a turned point of the sphere is drawn, and by how much lengths grow there.
  const magnified = ([x, y, z]) => {
    const depth = 1 - z, far = power * power * depth, all = 2 - depth + far;
    return {at: [2 * power * x / all, 2 * power * y / all, (2 - depth - far) / all], scale: 2 * power / all};
  };
  const views = scene.views.map(view => {
    const figure = element.appendChild(document.createElement("figure"));
    const box = figure.appendChild(document.createElement("div"));
    box.className = "view";
    const [canvas, marks] = ["surface", "marks"].map(name => box.appendChild(document.createElement("canvas")));
    marks.className = "marks"; canvas.tabIndex = 0; canvas.ariaLabel = view.caption;
    const caption = figure.appendChild(document.createElement("figcaption"));
    figure.insertAdjacentHTML("beforeend", view.legend);
    const gl = canvas.getContext("webgl2", {antialias: true});
    if (!gl) { figure.textContent = "This browser has no WebGL 2."; return () => {}; }
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, `#version 300 es
      in vec3 x; in vec3 colour; uniform mat3 turn; uniform float power, zoom, sphere, nearer; out vec3 c, p;
      void main() {
        vec3 y = turn * x;
        float depth = 1.0 - y.z, far = power * power * depth;
        if (sphere > 0.0) y = vec3(2.0 * power * y.xy, 2.0 - depth - far) / (2.0 - depth + far);
        float z = y.z + nearer;
        if (sphere == 0.0) y *= zoom;
        c = colour; p = y; gl_Position = vec4(0.95 * y.xy, -0.1 * z, 1.0);
      }`], [gl.FRAGMENT_SHADER, `#version 300 es
      precision highp float; in vec3 c, p; uniform float nearer; out vec4 pixel;
      void main() {
        vec3 n = normalize(cross(dFdx(p), dFdy(p)));
        float light = min(1.0, 0.62 + 0.42 * max(0.0, dot(n, vec3(-0.35, 0.45, 0.82))));
        pixel = vec4(c * (nearer > 0.0 ? 1.0 : light), 1.0);
      }`]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source); gl.compileShader(shader); gl.attachShader(program, shader);
    }
    gl.linkProgram(program); gl.useProgram(program); gl.enable(gl.DEPTH_TEST);
    const x = new Float32Array(bytes(view.positions)), colours = new Uint8Array(bytes(view.colours));
    const folded = new Uint32Array(bytes(view.folded)), starts = new Uint32Array(bytes(view.starts));
    const middles = new Float32Array(bytes(view.middles)), outward = new Float32Array(bytes(view.outward));
    const longest = new Float32Array(bytes(view.longest));
    const drawn = [...faces.keys()].filter(k => k % 3 === 0).map(k => k / 3).concat([...folded]);
    const corners = new Float32Array(9 * drawn.length), painted = new Uint8Array(9 * drawn.length);
    drawn.forEach((face, k) => {
      for (let j = 0; j < 9; j++) {
        corners[9 * k + j] = x[3 * faces[3 * face + Math.floor(j / 3)] + j % 3];
        painted[9 * k + j] = colours[3 * face + j % 3];
      }
    });
    const unseen = pixels => {
      const places = new Map();
      starts.forEach((start, cluster) => {
        let facing = 0, coloured = 0;
        for (let k = start; k < (starts[cluster + 1] ?? outward.length / 3); k++) {
          const area = turned(outward, k), size = Math.hypot(...area);
          if (size === 0) continue;
          const {at, scale} = view.sphere ? magnified(area.map(one => one / size)) : {at: [0, 0, area[2] / size], scale: zoom};
          const part = size * at[2] * (scale * pixels) ** 2;
          facing += part;
          if (2 * part >= longest[k] * scale * pixels) coloured += part;  // at least a pixel wide
        }
        if (coloured >= scene.seen ** 2 || (view.sphere && power > 1 && facing < 0)) return;
        const middle = turned(middles, cluster);
        const [right, up] = (view.sphere ? magnified(middle).at : middle.map(one => zoom * one)).map(one => pixels * one);
        places.set([Math.round(right / MARK), Math.round(up / MARK), facing >= 0].join(), [right, up, facing >= 0]);
      });
      return places.values();
    };
    const mark = (width, ratio) => {
      marks.width = marks.height = width * ratio;
      const pen = marks.getContext("2d");
      pen.setTransform(ratio, 0, 0, -ratio, width * ratio / 2, width * ratio / 2);
      for (const [right, up, front] of unseen(0.475 * width)) {
        for (const [radius, colour] of front ? [[MARK, "white"], [MARK - 1, scene.colour]] : [[MARK, scene.colour]]) {
          pen.beginPath(); pen.arc(right, up, radius, 0, 7);
          pen.fillStyle = pen.strokeStyle = colour; pen.lineWidth = 1.5;
          if (front) pen.fill(); else pen.stroke();
        }
      }
    };
    for (const [name, data, type] of [["x", corners, gl.FLOAT], ["colour", painted, gl.UNSIGNED_BYTE]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      const place = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, type, type !== gl.FLOAT, 0, 0);
    }
    canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
    canvas.onpointermove = event => { if (event.buttons) rotate(0.008 * event.movementX, 0.008 * event.movementY); };
    canvas.onwheel = event => {
      if (document.activeElement !== canvas) return;  // the page scrolls until the surface is clicked
      event.preventDefault();
      const factor = Math.exp(-0.002 * event.deltaY);
      if (view.sphere) power = Math.min(1e5, Math.max(1, power * factor)); else zoom = Math.min(50, Math.max(0.3, zoom * factor));
      draw();
    };
    canvas.ondblclick = () => { turn = [1, 0, 0, 0, 1, 0, 0, 0, 1]; power = zoom = 1; draw(); };
    return () => {
      const size = Math.round(canvas.clientWidth * devicePixelRatio);
      if (canvas.width !== size) canvas.width = canvas.height = size;
      gl.viewport(0, 0, size, size);
      gl.clearColor(1, 1, 1, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix3fv(gl.getUniformLocation(program, "turn"), true, turn);
      for (const [nearer, first, count] of [[0, 0, faces.length], [view.nearer, faces.length, 3 * folded.length]]) {
        for (const [name, value] of Object.entries({power, zoom, sphere: view.sphere ? 1 : 0, nearer}))
          gl.uniform1f(gl.getUniformLocation(program, name), value);
        gl.drawArrays(gl.TRIANGLES, first, count);
      }
      mark(canvas.clientWidth, devicePixelRatio);
      caption.textContent = view.caption
        + (view.sphere && power > 1 ? `, magnified ${(+power.toPrecision(2)).toLocaleString("en")} times in front` : "");
    };
  });
  const draw = () => requestAnimationFrame(() => views.forEach(view => view()));
  const rotate = (right, down) => {
    const [a, b, c, d] = [Math.cos(right), Math.sin(right), Math.cos(down), Math.sin(down)];
    const step = [a, 0, b, b * d, c, -a * d, -b * c, d, a * c];
    turn = turn.map((_, k) => [0, 1, 2].reduce((sum, j) => sum + step[3 * Math.floor(k / 3) + j] * turn[3 * j + k % 3], 0));
    draw();
  };
  addEventListener("resize", draw);
  draw();
}
}

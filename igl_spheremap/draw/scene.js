// Surfaces side by side that turn together under the mouse. Spheres are drawn after a Moebius map that magnifies
// what is in front: conformal, as the map itself.
for (const element of document.querySelectorAll("[data-scene]")) {
  const scene = JSON.parse(element.dataset.scene);
  const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
  const faces = new Uint32Array(bytes(scene.faces));
  let turn = [1, 0, 0, 0, 1, 0, 0, 0, 1], power = 1, zoom = 1;
  const views = scene.views.map(view => {
    const figure = element.appendChild(document.createElement("figure"));
    const canvas = figure.appendChild(document.createElement("canvas"));
    figure.appendChild(document.createElement("figcaption")).textContent = view.caption;
    const gl = canvas.getContext("webgl2", {antialias: true});
    if (!gl) { figure.textContent = "This browser has no WebGL 2."; return () => {}; }
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, `#version 300 es
      in vec3 x; in vec3 colour; uniform mat3 turn; uniform float power, zoom, sphere; out vec3 c, p;
      void main() {
        vec3 y = turn * x;
        float depth = 1.0 - y.z, far = power * power * depth;
        if (sphere > 0.0) y = vec3(2.0 * power * y.xy, 2.0 - depth - far) / (2.0 - depth + far); else y *= zoom;
        c = colour; p = y; gl_Position = vec4(0.95 * y.xy, -0.1 * y.z, 1.0);
      }`], [gl.FRAGMENT_SHADER, `#version 300 es
      precision highp float; in vec3 c, p; out vec4 pixel;
      void main() {
        vec3 n = normalize(cross(dFdx(p), dFdy(p)));
        pixel = vec4(c * min(1.0, 0.62 + 0.42 * max(0.0, dot(n, vec3(-0.35, 0.45, 0.82)))), 1.0);
      }`]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source); gl.compileShader(shader); gl.attachShader(program, shader);
    }
    gl.linkProgram(program); gl.useProgram(program); gl.enable(gl.DEPTH_TEST);
    const x = new Float32Array(bytes(view.positions)), colours = new Uint8Array(bytes(view.colours));
    const corners = new Float32Array(3 * faces.length), painted = new Uint8Array(3 * faces.length);
    faces.forEach((vertex, k) => {
      for (let j = 0; j < 3; j++) {
        corners[3 * k + j] = x[3 * vertex + j];
        painted[3 * k + j] = colours[3 * Math.floor(k / 3) + j];
      }
    });
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
      for (const [name, value] of Object.entries({power, zoom, sphere: view.sphere ? 1 : 0}))
        gl.uniform1f(gl.getUniformLocation(program, name), value);
      gl.drawArrays(gl.TRIANGLES, 0, faces.length);
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

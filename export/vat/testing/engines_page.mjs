// A page of run_in_browser.mjs: the documented shaders of Godot and Unity, translated to GLSL word
// by word, run on every vertex of every frame.
import { FloatType } from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const name = new URLSearchParams(location.search).get('name');
const gl = document.querySelector('canvas').getContext('webgl2');
const header = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D;
in vec2 uvOfTexel; uniform float secondsShown; out vec3 foundPosition; out vec3 foundNormal;\n`;

const text = async (url) => (await fetch(url)).text();
const numbers = async (url, Type) => new Type(await (await fetch(url)).arrayBuffer());

/** Godot's shading language is GLSL with hints and defaults at the uniforms. */
function fromGodot(code) {
  const vertex = code
    .slice(code.indexOf('shader_type'), code.indexOf('void fragment()'))
    .replace('shader_type spatial;', '')
    .replace(/^uniform (\w+) (\w+)\s*[:=][^;]*;/gm, 'uniform $1 $2;');
  return `${header} vec2 UV2; float TIME; vec3 VERTEX, NORMAL; ${vertex}
    void main() {
      UV2 = uvOfTexel; TIME = secondsShown; vertex();
      foundPosition = VERTEX; foundNormal = NORMAL;
    }`;
}

function fromUnity(code) {
  const translated = code
    .replace(/\bfloat([23])\b/g, 'vec$1')
    .replace(/\bint3\b/g, 'ivec3')
    .replace(/\bUnityTexture2D\b/g, 'sampler2D')
    .replace(
      'positions.tex.GetDimensions(columns, rows);',
      'columns = float(textureSize(positions, 0).x); rows = float(textureSize(positions, 0).y);',
    )
    .replace(/(\w+)\.tex\.Load\((\w+)\)/g, 'texelFetch($1, $2.xy, $2.z)');
  return `${header} uniform sampler2D positions, normals;
    uniform float frames, rows_per_frame, fps; uniform vec3 minimum, maximum;
    ${translated}
    void main() {
      KeyposeVat_float(uvOfTexel, secondsShown, positions, normals, frames, rows_per_frame, fps,
        minimum, maximum, foundPosition, foundNormal);
    }`;
}

function compile(vertex) {
  const program = gl.createProgram();
  const stages = [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, '#version 300 es\nvoid main() {}'],
  ];
  for (const [kind, code] of stages) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, code);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
      throw new Error(`${gl.getShaderInfoLog(shader)}\n${code}`);
    gl.attachShader(program, shader);
  }
  gl.transformFeedbackVaryings(program, ['foundPosition', 'foundNormal'], gl.INTERLEAVED_ATTRIBS);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS))
    throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  return program;
}

function bindTexture(unit, upload) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  upload();
}

/** RGB rows in the other order. */
function upsideDown(values, width, height) {
  const out = new Float32Array(values.length);
  const stride = values.length / height;
  for (let y = 0; y < height; ++y)
    out.set(values.subarray(y * stride, (y + 1) * stride), (height - 1 - y) * stride);
  return out;
}

/** Six numbers per vertex: position and normal at a time. */
function run(program, seconds, count) {
  gl.uniform1f(gl.getUniformLocation(program, 'secondsShown'), seconds);
  const out = gl.createBuffer();
  gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, out);
  gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, 24 * count, gl.STREAM_READ);
  gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, out);
  gl.enable(gl.RASTERIZER_DISCARD);
  gl.beginTransformFeedback(gl.POINTS);
  gl.drawArrays(gl.POINTS, 0, count);
  gl.endTransformFeedback();
  const found = new Float32Array(6 * count);
  gl.getBufferSubData(gl.TRANSFORM_FEEDBACK_BUFFER, 0, found);
  return found;
}

function setUniforms(program, vat) {
  const at = (uniform) => gl.getUniformLocation(program, uniform);
  gl.uniform1i(at('positions'), 0);
  gl.uniform1i(at('normals'), 1);
  gl.uniform1f(at('fps'), vat.fps);
  const whole =
    gl.getActiveUniform(
      program,
      [...Array(gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS)).keys()].find(
        (i) => gl.getActiveUniform(program, i).name === 'frames',
      ),
    ).type === gl.INT;
  for (const key of ['frames', 'rows_per_frame'])
    whole ? gl.uniform1i(at(key), vat[key]) : gl.uniform1f(at(key), vat[key]);
  gl.uniform3fv(at('minimum'), vat.positions.minimum);
  gl.uniform3fv(at('maximum'), vat.positions.maximum);
}

/**
 * The largest errors over all frames. `mirror` is -1 where the engine's x is the other way round.
 */
function compare(code, uvs, vat, truth, mirror) {
  const program = compile(code);
  const attribute = gl.getAttribLocation(program, 'uvOfTexel');
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, uvs, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(attribute);
  gl.vertexAttribPointer(attribute, 2, gl.FLOAT, false, 0, 0);
  setUniforms(program, vat);
  let [error, normal] = [0, 0];
  for (let shown = 0; shown < 2 * vat.frames; ++shown) {
    // twice round
    const frame = shown % vat.frames;
    const found = run(program, (shown + 0.5) / vat.fps, vat.vertices);
    for (let v = 0; v < vat.vertices; ++v) {
      const [point, direction] = [[], []];
      for (let axis = 0; axis < 3; ++axis) {
        const sign = axis === 0 ? mirror : 1;
        point.push(
          found[6 * v + axis] -
            sign * truth.points[3 * (frame * truth.json.vertices + truth.source[v]) + axis],
        );
        direction.push(
          found[6 * v + 3 + axis] - sign * truth.normals[3 * (frame * vat.vertices + v) + axis],
        );
      }
      error = Math.max(error, Math.hypot(...point));
      normal = Math.max(normal, Math.hypot(...direction));
    }
  }
  return { error: error / truth.json.diagonal, normal };
}

async function main() {
  const vat = await (await fetch(`/vat/${name}.json`)).json();
  const truth = {
    json: await (await fetch('/truth/truth.json')).json(),
    points: await numbers('/truth/points.f64', Float64Array),
    normals: await numbers('/truth/split_normals.f64', Float64Array),
    source: await numbers('/truth/split_source.i32', Int32Array),
  };
  let uvs = null;
  (await new GLTFLoader().loadAsync(`/vat/${vat.mesh}`)).scene.traverse((mesh) => {
    uvs ??= mesh.geometry?.getAttribute('uv1').array;
  });
  const exr = await new EXRLoader().setDataType(FloatType).loadAsync(`/vat/${vat.positions.exr}`);
  const image = await createImageBitmap(await (await fetch(`/vat/${vat.normals.png}`)).blob(), {
    colorSpaceConversion: 'none',
  });
  const turnedImage = await createImageBitmap(image, { imageOrientation: 'flipY' });
  const positions = await numbers('/positions.f32', Float32Array);
  const { columns, rows } = vat;
  const upload = (inside, format, values) =>
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, columns, rows, 0, format, gl.FLOAT, values);

  // Godot: the top row first. three.js's loader gives the bottom row first.
  bindTexture(0, () => upload(gl.RGBA32F, gl.RGBA, upsideDown(exr.image.data, columns, rows)));
  bindTexture(1, () => gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, image));
  const godot = compare(fromGodot(await text('/keypose_vat.gdshader')), uvs, vat, truth, 1);

  // Unity: the bottom row first, and glTFast turns the v axis.
  bindTexture(0, () => upload(gl.RGB32F, gl.RGB, upsideDown(positions, columns, rows)));
  bindTexture(1, () =>
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, turnedImage),
  );
  const turned = uvs.map((value, i) => (i % 2 === 0 ? value : 1 - value));
  const unity = compare(fromUnity(await text('/KeyposeVat.hlsl')), turned, vat, truth, -1);
  globalThis.figures = {
    vertices: vat.vertices,
    godot_error_over_diagonal: godot.error,
    godot_normal_error: godot.normal,
    unity_error_over_diagonal: unity.error,
    unity_normal_error: unity.normal,
  };
}

main().catch((error) => {
  globalThis.fault = error.stack ?? String(error);
});

// The figure: its surface with the blended textures of the poses, its edges, and its keys as pale
// onion skins.
import {
  BackSide,
  BufferAttribute,
  BufferGeometry,
  Color,
  DataTexture,
  DoubleSide,
  DynamicDrawUsage,
  Group,
  LinearFilter,
  LinearMipmapLinearFilter,
  Mesh,
  MeshBasicMaterial,
  ShaderMaterial,
  SRGBColorSpace,
  Texture,
} from 'three';

const vertexShader = `
varying vec2 spot;
varying vec3 normal_in_view;
void main() {
  spot = uv;
  normal_in_view = normalMatrix * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

// The textures already contain the lamps' light; a little shading shows the shape. Without a
// texture, two lamps beside the camera light the figure.
const fragmentShader = `
uniform sampler2D first, second;
uniform float share, textured;
varying vec2 spot;
varying vec3 normal_in_view;
void main() {
  vec3 n = normalize(gl_FrontFacing ? normal_in_view : -normal_in_view);
  float light = 0.30 + 0.62 * max(0.0, dot(n, normalize(vec3(-0.45, 0.65, 0.75))))
                     + 0.24 * max(0.0, dot(n, normalize(vec3(0.75, -0.10, 0.60))));
  vec3 paint = mix(texture2D(first, spot).rgb, texture2D(second, spot).rgb, share);
  vec3 painted = paint * mix(1.0, light, 0.2), plain = vec3(0.50, 0.48, 0.45) * light;
  gl_FragColor = linearToOutputTexel(vec4(mix(plain, painted, textured), 1.0));
}`;

function pictureTexture(uri, changed) {
  const texture = new Texture();
  texture.colorSpace = SRGBColorSpace;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.magFilter = LinearFilter;
  texture.anisotropy = 8;
  const picture = new Image();
  picture.onload = () => {
    texture.image = picture;
    texture.needsUpdate = true;
    changed();
  };
  picture.src = uri;
  return texture;
}

function greyTexture() {
  const texture = new DataTexture(new Uint8Array([188, 184, 178, 255]), 1, 1);
  texture.needsUpdate = true;
  return texture;
}

/** The two textures that weigh most, and the share of the second. */
export function twoOf(weights) {
  const order = weights.map((_, i) => i).sort((a, b) => weights[b] - weights[a] || a - b);
  const first = order[0] ?? 0,
    second = order[1] ?? first;
  const sum = (weights[first] ?? 0) + (weights[second] ?? 0);
  if (second === first || !(sum > 0)) return { first, second: first, share: 0 };
  return { first, second, share: weights[second] / sum };
}

export class Figure extends Group {
  constructor(data, changed) {
    super();
    this.data = data;
    this.geometry = this.makeGeometry(true);
    this.textures = data.textures.map((uri) => pictureTexture(uri, changed));
    const grey = this.textures[0] ?? greyTexture();
    this.uniforms = {
      first: { value: grey },
      second: { value: grey },
      share: { value: 0 },
      textured: { value: this.textures.length > 0 ? 1 : 0 },
    };
    const material = new ShaderMaterial({
      uniforms: this.uniforms,
      vertexShader,
      fragmentShader,
      side: DoubleSide,
    });
    material.polygonOffset = true;
    material.polygonOffsetFactor = material.polygonOffsetUnits = 1;
    this.add(new Mesh(this.geometry, material));
    const lines = new MeshBasicMaterial({
      color: 0x1d3b57,
      wireframe: true,
      transparent: true,
      opacity: 0.45,
    });
    this.edges = new Mesh(this.geometry, lines);
    this.edges.visible = false;
    this.add(this.edges);
    this.skins = new Group();
    this.skins.visible = false;
    this.add(this.skins);
  }

  makeGeometry(dynamic) {
    const { data } = this;
    const geometry = new BufferGeometry();
    const drawn = data.source.length;
    geometry.setIndex(new BufferAttribute(data.faces, 1));
    for (const name of ['position', 'normal']) {
      const attribute = new BufferAttribute(new Float32Array(3 * drawn), 3);
      if (dynamic) attribute.setUsage(DynamicDrawUsage);
      geometry.setAttribute(name, attribute);
    }
    geometry.setAttribute('uv', new BufferAttribute(data.uv, 2));
    return geometry;
  }

  show(moment) {
    this.place(this.geometry, this.data.frames.between(moment.a, moment.b, moment.share));
    if (this.textures.length === 0) return;
    const { first, second, share } = twoOf(moment.weights);
    this.uniforms.first.value = this.textures[first];
    this.uniforms.second.value = this.textures[second];
    this.uniforms.share.value = share;
  }

  /** Normals are those of the mesh's vertices, so that no seam of the texture shows as a crease. */
  place(geometry, points) {
    const { faces, source } = this.data;
    const normals = new Float32Array(points.length);
    for (let f = 0; f < faces.length; f += 3) {
      const a = 3 * source[faces[f]],
        b = 3 * source[faces[f + 1]],
        c = 3 * source[faces[f + 2]];
      const ux = points[b] - points[a],
        uy = points[b + 1] - points[a + 1],
        uz = points[b + 2] - points[a + 2];
      const vx = points[c] - points[a],
        vy = points[c + 1] - points[a + 1],
        vz = points[c + 2] - points[a + 2];
      const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      for (const corner of [a, b, c]) for (let k = 0; k < 3; ++k) normals[corner + k] += n[k];
    }
    const to = geometry.attributes.position,
      of = geometry.attributes.normal;
    for (let i = 0; i < source.length; ++i) {
      const v = 3 * source[i];
      to.setXYZ(i, points[v], points[v + 1], points[v + 2]);
      const length = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1;
      of.setXYZ(i, normals[v] / length, normals[v + 1] / length, normals[v + 2] / length);
    }
    to.needsUpdate = of.needsUpdate = true;
  }

  /** Pale skins of the keys, blue to red from first to last. */
  showSkins(on) {
    this.skins.visible = on;
    if (!on || this.skins.children.length > 0) return;
    const keys = this.data.keys;
    keys.forEach((key, i) => {
      const geometry = this.makeGeometry(false);
      this.place(geometry, this.data.frames.at(key));
      const color = new Color().setHSL(
        0.6 - 0.58 * (keys.length > 1 ? i / (keys.length - 1) : 0),
        0.7,
        0.5,
      );
      const material = new MeshBasicMaterial({
        color,
        transparent: true,
        opacity: 0.22,
        depthWrite: false,
        side: BackSide,
      });
      this.skins.add(new Mesh(geometry, material));
    });
  }

  set textured(on) {
    this.uniforms.textured.value = on && this.textures.length > 0 ? 1 : 0;
  }
  set wireframe(on) {
    this.edges.visible = on;
  }
}

// Unpacks the page's data for the player: JSON with binary parts in base64.

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

const words = (base64) => new Uint16Array(bytesOf(base64).buffer);
const indices = (base64, wide) => (wide ? new Uint32Array(bytesOf(base64).buffer) : words(base64));

/** Positions of all stored frames; each is taken apart when it is first shown. */
class Frames {
  constructor(data) {
    this.quantised = words(data.positions);
    this.vertices = data.vertices;
    this.count = this.quantised.length / (3 * data.vertices);
    this.low = data.low;
    this.step = data.step;
    this.known = new Map();
  }

  at(frame) {
    if (!this.known.has(frame)) {
      const points = new Float32Array(3 * this.vertices);
      const begin = frame * points.length;
      for (let i = 0; i < points.length; ++i)
        points[i] = this.low[i % 3] + this.step * this.quantised[begin + i];
      this.known.set(frame, points);
    }
    return this.known.get(frame);
  }

  /** The way from frame a to frame b, `share` of it done. */
  between(a, b, share) {
    if (share === 0 || a === b) return this.at(a);
    const from = this.at(a),
      to = this.at(b);
    return from.map((x, i) => x + share * (to[i] - x));
  }
}

/**
 * `faces`: corners as indices of drawn vertices; `source`: the mesh's vertex that each drawn one is
 * a copy of (seams of the texture part them); `uv`: two numbers in 0 to 1 each. `moments`: one
 * picture of the animation each, {a, b, share, weights}.
 */
export function unpack(data) {
  const uv = Float32Array.from(words(data.uv), (x) => x / 65535);
  return {
    ...data,
    frames: new Frames(data),
    faces: indices(data.faces, data.wide),
    source: indices(data.source, data.wide),
    uv,
  };
}

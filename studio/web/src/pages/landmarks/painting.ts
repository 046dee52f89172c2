// Numbers painted on vertices, with undo. Knows nothing of the page.

/** One stroke: what a layer had at some vertices, and what it has now. */
interface Stroke {
  layer: string
  vertices: Uint32Array
  before: Float32Array
  after: Float32Array
}

/** The layer of stiffness; regions are layers 'region:NAME' of 0 and 1. */
export const kStiffness = 'stiffness'
export const regionLayer = (name: string) => `region:${name}`

const kLongest = 100

export class Painting {
  private readonly layers = new Map<string, Float32Array>()
  private past: Stroke[] = []
  private future: Stroke[] = []
  private open: { layer: string; before: Map<number, number> } | null = null

  constructor(private readonly vertices: number) {}

  /** The values of a layer, to be read only; a new one has `fill` everywhere. */
  layer(name: string, fill = 0): Float32Array {
    let values = this.layers.get(name)
    if (!values) {
      values = new Float32Array(this.vertices).fill(fill)
      this.layers.set(name, values)
    }
    return values
  }

  /** A layer from a file. Undo ends here: it would write over the other's work. */
  setLayer(name: string, values: Float32Array): void {
    this.layers.set(name, values)
    this.forgetStrokes()
  }

  dropLayer(name: string): void {
    this.layers.delete(name)
    this.past = this.past.filter((stroke) => stroke.layer !== name)
    this.future = this.future.filter((stroke) => stroke.layer !== name)
  }

  forgetStrokes(): void {
    this.past = []
    this.future = []
  }

  begin(layer: string): void {
    this.open = { layer, before: new Map() }
  }

  /** Paints a value; only between begin and end. */
  paint(vertices: Iterable<number>, value: number): void {
    if (!this.open) return
    const values = this.layer(this.open.layer)
    for (const vertex of vertices) {
      if (!this.open.before.has(vertex)) this.open.before.set(vertex, values[vertex])
      values[vertex] = value
    }
  }

  /** True if the stroke has changed anything. */
  end(): boolean {
    if (!this.open) return false
    const { layer, before } = this.open
    this.open = null
    const values = this.layer(layer)
    const vertices = Uint32Array.from(before.keys()).filter((v) => values[v] !== before.get(v))
    if (vertices.length === 0) return false
    const stroke: Stroke = {
      layer,
      vertices,
      before: Float32Array.from(vertices, (vertex) => before.get(vertex)!),
      after: Float32Array.from(vertices, (vertex) => values[vertex]),
    }
    this.past = [...this.past, stroke].slice(-kLongest)
    this.future = []
    return true
  }

  get canUndo(): boolean {
    return this.past.length > 0
  }
  get canRedo(): boolean {
    return this.future.length > 0
  }

  /** The layer that has changed, or ''. */
  undo(): string {
    const stroke = this.past.at(-1)
    if (!stroke) return ''
    this.past = this.past.slice(0, -1)
    this.future = [...this.future, stroke]
    return this.apply(stroke, stroke.before)
  }

  redo(): string {
    const stroke = this.future.at(-1)
    if (!stroke) return ''
    this.future = this.future.slice(0, -1)
    this.past = [...this.past, stroke]
    return this.apply(stroke, stroke.after)
  }

  private apply(stroke: Stroke, to: Float32Array): string {
    const values = this.layer(stroke.layer)
    stroke.vertices.forEach((vertex, i) => (values[vertex] = to[i]))
    return stroke.layer
  }
}

/** For each vertex the vertices that it shares a face with, as one list with starts. */
export interface Neighbours {
  starts: Uint32Array
  list: Uint32Array
}

export function neighboursOf(indices: Uint32Array, vertices: number): Neighbours {
  const starts = new Uint32Array(vertices + 1)
  for (const vertex of indices) starts[vertex + 1] += 2
  for (let v = 0; v < vertices; ++v) starts[v + 1] += starts[v]
  const list = new Uint32Array(starts[vertices])
  const next = starts.slice(0, vertices)
  for (let corner = 0; corner < indices.length; corner += 3)
    for (let k = 0; k < 3; ++k) {
      const vertex = indices[corner + k]
      list[next[vertex]++] = indices[corner + ((k + 1) % 3)]
      list[next[vertex]++] = indices[corner + ((k + 2) % 3)]
    }
  return { starts, list }
}

/** Of `near`, what hangs together with `start`: a brush on the arm must not paint the belly. */
export function connected(near: number[], start: number[], neighbours: Neighbours): number[] {
  const left = new Set(near)
  const found = start.filter((vertex) => left.delete(vertex))
  for (let i = 0; i < found.length; ++i) {
    const vertex = found[i]
    for (let at = neighbours.starts[vertex]; at < neighbours.starts[vertex + 1]; ++at)
      if (left.delete(neighbours.list[at])) found.push(neighbours.list[at])
  }
  return found
}

/** Factors of stiffness that the brush offers. */
export const kFactors = [
  { name: 'Soft', factor: 1 / 8, key: '1', about: 'stretches and bends easily' },
  { name: 'Normal', factor: 1, key: '2', about: 'as the clay is by default' },
  { name: 'Stiff', factor: 8, key: '3', about: 'keeps its shape more' },
  { name: 'Rigid', factor: 100, key: '4', about: 'moves as one body' },
]

/** A factor's place on the colour scale: 1/8 at 0, 128 at 1. */
export function levelOf(factor: number): number {
  return (Math.log2(factor) + 3) / 10
}

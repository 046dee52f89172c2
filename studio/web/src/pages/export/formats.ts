// The formats of the animation: what each is for, how it is asked for, what was written.
import type { Stage, Step } from '../../api'

export interface Result {
  path: string
  label: string
  bytes: number
}

interface Known {
  title: string
  use: string
}

const kKnown: Record<string, Known> = {
  glb: {
    title: 'glTF',
    use: 'Phones, web pages, game engines: one light file with few shapes; the error is measured',
  },
  'glb-full': {
    title: 'glTF, full',
    use: 'Every frame a morph target, textures of full size and of all poses',
  },
  'glb-few': {
    title: 'glTF, few targets',
    use: 'Players that blend at most 8 shapes; textures of full size',
  },
  fbx: { title: 'FBX', use: 'Blender, Unity, Unreal: blend shapes' },
  obj: {
    title: 'OBJ sequence',
    use: 'Blender’s Stop-motion-OBJ: a numbered file for each frame, some 2 MB',
  },
  ply: {
    title: 'PLY sequence',
    use: 'Blender’s Stop-motion-OBJ and MeshLab: a file for each frame',
  },
  pc2: { title: 'PC2', use: 'Point cache for Blender’s Mesh Cache; the add-on binds it for you' },
  mdd: { title: 'MDD', use: 'Point cache for Maya, Houdini and Blender' },
  vat: {
    title: 'Vertex texture',
    use: 'Godot, Unity, three.js: frames in a picture, played by a shader',
  },
  usda: { title: 'USD', use: 'usdview, Houdini, Omniverse: time samples; three.js shows it still' },
  video: {
    title: 'Film',
    use: 'MP4 to look at and to send round',
  },
  blender: {
    title: 'Blender add-on',
    use: 'File > Import > Keypose project: character, materials, keys as markers',
  },
}

export interface Format {
  id: string
  title: string
  use: string
  on: boolean
}

/** What animation.json says of a format that was written. */
export interface Note {
  format: string
  /** below out/animation; a folder ends in '/' */
  files: string[]
  bytes: number
  /** the farthest that a vertex of any frame is off, over the figure's diagonal */
  error_over_diagonal?: number
  morph_targets?: number
}

const kListed = 'formats'

function words(id: string): { title: string; use: string } {
  return kKnown[id] ?? { title: id, use: '' }
}

const listOf = (text: string): string[] => text.split(/[\s,]+/).filter((one) => one !== '')

/** What `formats` can hold, as the option's help lists it: "formats to write, ...: glb, video". */
function namesIn(help: string, now: string): string[] {
  const listed = help.includes(':') ? listOf(help.slice(help.lastIndexOf(':') + 1)) : []
  return [...new Set([...listed, ...listOf(now)])]
}

/** Formats that the export stage offers. */
export function formatsOf(stage: Stage, step: Step): Format[] {
  const list = stage.options.find((option) => option.name === kListed)
  if (!list) return []
  const now = step.options[kListed] ?? list.default
  const on = listOf(now)
  return namesIn(list.help, now).map((id) => ({ id, ...words(id), on: on.includes(id) }))
}

/** The options of the stage that are no formats. */
export const otherOptions = (stage: Stage): Stage['options'] =>
  stage.options.filter((one) => one.name !== kListed)

/** The option's value for these formats; null: it is that already. */
export function askedBy(formats: Format[], wanted: Set<string>): string | null {
  if (formats.every((one) => one.on === wanted.has(one.id))) return null
  return formats
    .filter((one) => wanted.has(one.id))
    .map((one) => one.id)
    .join(',')
}

/** A figure of this size stands for those who do not think in shares. */
const kFigure_mm = 200
/** Nobody sees less on it. */
const kLeast_mm = 0.001

/** "Off by at most 0.02 mm on a figure of 20 cm (0.01 %)" */
export function errorWords(error_over_diagonal: number): string {
  const off_mm = error_over_diagonal * kFigure_mm
  if (off_mm < kLeast_mm) return 'Exact: off by less than 0.001 mm on a figure of 20 cm'
  const short = (value: number) =>
    value >= 100 ? value.toFixed(0) : String(Number(value.toPrecision(2)))
  return `Off by at most ${short(off_mm)} mm on a figure of 20 cm ` +
    `(${short(100 * error_over_diagonal)} %)`
}

/** Size and error of what was written, as one line. */
export function noteWords(note: Note): string {
  const parts: string[] = []
  if (note.error_over_diagonal !== undefined) parts.push(errorWords(note.error_over_diagonal))
  if (note.morph_targets !== undefined) parts.push(`${note.morph_targets} shapes`)
  return parts.join(', ')
}

export const sizeOf = (files: Result[]): number => files.reduce((sum, one) => sum + one.bytes, 0)

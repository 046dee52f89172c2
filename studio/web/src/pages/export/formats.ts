// The formats of the animation: what each is for, which option asks for it, which files it makes.
import type { Stage, Step } from '../../api'
import type { KnownOption } from '../run/use_stages'

export interface Result {
  path: string
  label: string
  bytes: number
}

interface Known {
  title: string
  use: string
  /** which results are of this format */
  files: RegExp
}

const kKnown: Record<string, Known> = {
  glb: {
    title: 'glTF',
    use: 'Web pages and game engines: one file, every frame a morph target',
    files: /(^|\/)(?!.*few)[^/]*\.glb$/,
  },
  'glb-few': {
    title: 'glTF, few targets',
    use: 'Players that blend at most 8 shapes: smaller, the error is measured',
    files: /few[^/]*\.glb$/,
  },
  fbx: { title: 'FBX', use: 'Blender, Unity, Unreal: blend shapes', files: /\.fbx$/ },
  obj: {
    title: 'OBJ sequence',
    use: 'Blender’s Stop-motion-OBJ: a numbered file for each frame',
    files: /\/obj\/|\.obj$|\.mtl$/,
  },
  ply: {
    title: 'PLY sequence',
    use: 'Blender’s Stop-motion-OBJ and MeshLab: a file for each frame',
    files: /\/ply\/|\.ply$/,
  },
  pc2: { title: 'PC2', use: 'Point cache for Blender’s Mesh Cache', files: /\.pc2$/ },
  mdd: { title: 'MDD', use: 'Point cache for Maya, Houdini and Blender', files: /\.mdd$/ },
  vat: {
    title: 'Vertex texture',
    use: 'Godot, Unity, three.js: frames in a picture, played by a shader',
    files: /\/vat\//,
  },
  usda: { title: 'USD', use: 'usdview, Houdini, Omniverse: time samples', files: /\.usda?$/ },
  video: {
    title: 'Film',
    use: 'MP4 to look at and to send round',
    files: /\.(mp4|gif)$/,
  },
  blender: {
    title: 'Blender add-on',
    use: 'File > Import > Keypose project: character, materials, keys as markers',
    files: /blender|addon/,
  },
}

export interface Format {
  id: string
  title: string
  use: string
  on: boolean
  /** cannot be left out */
  always: boolean
}

export interface Asked {
  option: string
  value: string
}

const kListed = 'formats'

function words(id: string): { title: string; use: string } {
  return kKnown[id] ?? { title: id, use: '' }
}

const listOf = (text: string): string[] =>
  text.split(/[\s,]+/).filter((one) => one !== '')

/** What `formats` can hold: its choices, or else the formats that its help or default names. */
function namesIn(option: KnownOption, now: string): string[] {
  if (option.choices && option.choices.length > 0) return option.choices
  const said = listOf(`${option.help} ${option.default}`.replace(/[^\w-]/g, ' '))
  const known = Object.keys(kKnown).filter((id) => said.includes(id))
  return [...new Set([...known, ...listOf(now)])]
}

/** Formats that the export stage offers: by its option `formats`, or by one switch for each. */
export function formatsOf(stage: Stage, step: Step): Format[] {
  const list = stage.options.find((option) => option.name === kListed)
  if (list) {
    const now = step.options[kListed] ?? list.default
    const on = listOf(now)
    return namesIn(list, now).map((id) => {
      return { id, ...words(id), on: on.includes(id), always: false }
    })
  }
  const switches = stage.options.filter((one) => one.type === 'bool' && kKnown[one.name])
  const byOption = switches.map((one) => ({
    id: one.name,
    ...words(one.name),
    on: (step.options[one.name] ?? one.default) === 'true',
    always: false,
  }))
  return [{ id: 'glb', ...words('glb'), on: true, always: true }, ...byOption]
}

/** The options of the stage that are no formats. */
export function otherOptions(stage: Stage): Stage['options'] {
  const listed = stage.options.some((option) => option.name === kListed)
  return stage.options.filter((one) => {
    if (one.name === kListed) return false
    return listed || one.type !== 'bool' || !kKnown[one.name]
  })
}

/** The changes of options that turn the formats as they are into those that are wanted. */
export function askedBy(stage: Stage, formats: Format[], wanted: Set<string>): Asked[] {
  if (formats.every((one) => one.on === wanted.has(one.id))) return []
  if (stage.options.some((option) => option.name === kListed)) {
    const value = formats.filter((one) => wanted.has(one.id)).map((one) => one.id)
    return [{ option: kListed, value: value.join(',') }]
  }
  return formats
    .filter((one) => !one.always && one.on !== wanted.has(one.id))
    .map((one) => ({ option: one.id, value: String(wanted.has(one.id)) }))
}

/** Only files of the animation count: out/POSE/mesh.obj is no export. */
export function filesOf(id: string, results: Result[]): Result[] {
  const pattern = kKnown[id]?.files
  if (!pattern) return []
  return results.filter((one) => /(^|\/)animation\//.test(one.path) && pattern.test(one.path))
}

export const sizeOf = (files: Result[]): number => files.reduce((sum, one) => sum + one.bytes, 0)

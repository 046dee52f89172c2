// What a shot may consist of beside its film, in words: when each part is needed, what may be chosen
// for it, and what does not go together. Knows nothing of the page.
import { count } from '../../words'
import type { CameraKind, Film, Offers } from './shot_api'

export interface Parts {
  camera: CameraKind
  plate: string
  mattes: string
  holdout: string
  set: string
}
export type PartName = Exclude<keyof Parts, 'camera'>

export const kNoParts: Parts = { camera: 'still', plate: '', mattes: '', holdout: '', set: '' }

export const partsOf = ({ camera, plate, mattes, holdout, set }: Film): Parts => ({
  camera,
  plate,
  mattes,
  holdout,
  set,
})

/**
 * What the form shows after the file was read again: of each part what was chosen since `before`, what
 * the file had then, else what it has now.
 */
export function partsAfter(chosen: Parts, before: Parts, now: Parts): Parts {
  const of = <Name extends keyof Parts>(name: Name): Parts[Name] =>
    chosen[name] === before[name] ? now[name] : chosen[name]
  return {
    camera: of('camera'),
    plate: of('plate'),
    mattes: of('mattes'),
    holdout: of('holdout'),
    set: of('set'),
  }
}

export interface PartWords {
  name: PartName
  label: string
  /** of the choice to have none */
  none: string
  /** when it is needed */
  when: string
}

const kPlate: Record<CameraKind, PartWords> = {
  still: {
    name: 'plate',
    label: 'Empty set',
    none: 'made from the film',
    when:
      'A picture of the set without the character. Needed where the character hides a place in ' +
      'every frame; elsewhere the film itself shows it.',
  },
  moving: {
    name: 'plate',
    label: 'Plates of the empty set',
    none: 'none yet',
    when:
      'Needed for the pictures between: a film of the empty set with the same move, in the same ' +
      'light; numbered pictures or a video, one for each filmed frame or, better, one for each ' +
      'picture of the finished shot.',
  },
}

const kOthers: PartWords[] = [
  {
    name: 'mattes',
    label: 'Mattes',
    none: 'none',
    when:
      'White where the character is, one for each frame: numbered pictures, also with alpha, or ' +
      'a video. The surest help to find the camera; needed where texture and clicks are not enough.',
  },
  {
    name: 'set',
    label: 'Mesh of the set',
    none: 'none: a flat table',
    when:
      'Props and furniture as a mesh, in the shot’s world. Needed where something stands before ' +
      'the character or its shadow falls on more than the table: it hides the one and catches ' +
      'the other.',
  },
  {
    name: 'holdout',
    label: 'Holdout',
    none: 'none',
    when:
      'Instead of a mesh: a picture that is white where props stand before the character. Only ' +
      'for a camera that stands still.',
  },
]

export const kCameraWords: Record<CameraKind, string> = {
  still: 'It stands on a tripod: one place for all frames.',
  moving:
    'It is moved during the shot: each frame gets a camera of its own, also those between the ' +
    'poses, and the empty set must be filmed with the same move.',
}

export const partWords = (camera: CameraKind): PartWords[] => [kPlate[camera], ...kOthers]

interface Option {
  path: string
  text: string
}

const plain = (paths: string[]): Option[] => paths.map((path) => ({ path, text: path }))

/** What may be chosen; what is set now is among it, wherever it lies. */
export function optionsOf(
  part: PartName,
  offers: Offers,
  camera: CameraKind,
  now: string,
  film: string,
): Option[] {
  const folders = offers.folders
    .filter(({ path }) => path !== film)
    .map(({ path, pictures }) => ({ path, text: `${path} · ${count(pictures, 'picture')}` }))
  const films = [...folders, ...plain(offers.videos)]
  const options = {
    plate: camera === 'moving' ? films : [...plain(offers.pictures), ...films],
    mattes: films,
    holdout: plain(offers.pictures),
    set: plain(offers.meshes),
  }[part]
  const known = now === '' || options.some(({ path }) => path === now)
  return known ? options : [{ path: now, text: now }, ...options]
}

/** Why these cannot be saved, or ''. */
export function faultOf(parts: Parts, offers: Offers): string {
  if (parts.camera === 'moving' && offers.pictures.includes(parts.plate))
    return 'The camera moves, so one picture of the empty set is not enough: choose plates.'
  return ''
}

/** What will be missing later, or ''. */
export function lackOf(parts: Parts): string {
  if (parts.camera === 'moving' && parts.plate === '')
    return 'Without plates the camera is found, but no pictures can be made.'
  if (parts.camera === 'moving' && parts.holdout !== '')
    return 'The holdout stays where it is while the camera moves: a mesh of the set would move along.'
  return ''
}

// What is sent to the project's folders, and under which names. Knows nothing of the page.
import type { Found } from '../pages/new_project/files'

export type Place = 'shot' | 'calibration' | 'scan' | 'film' | 'armature'

export interface Item {
  file: File
  /** below the place's folder */
  name: string
}

const kFilms = 'mp4 mov m4v avi mkv webm mts m2ts mpg mpeg mxf'.split(' ')
const kPictures = 'png jpg jpeg tif tiff bmp exr dpx'.split(' ')

/** What a browser's dialog offers for each place. */
export const kAccepts: Record<Place, string> = {
  shot: kFilms.map((kind) => `.${kind}`).join(','),
  film: kFilms.map((kind) => `.${kind}`).join(','),
  calibration: '.yml,.yaml,.json,.txt,.toml,.xml,.csv',
  scan: '.obj,.ply,.off,.stl,.glb,.png,.jpg,.jpeg,.tif',
  armature: '.txt,.json,.bvh,.ply,.obj,.png,.jpg,.csv',
}

const endingOf = (name: string) => name.slice(name.lastIndexOf('.') + 1).toLowerCase()
export const isFilm = (name: string): boolean => kFilms.includes(endingOf(name))
const isPicture = (name: string) => kPictures.includes(endingOf(name))
const isHidden = (path: string) => path.split('/').some((part) => part.startsWith('.'))

/** The folders that tell what a picture is: "walk/masks/cam1/0001.png" is masks/cam1/0001.png. */
function pictureName(parts: string[]): string {
  const masks = parts.length >= 3 && parts.at(-3) === 'masks'
  return parts.slice(masks ? -3 : -2).join('/')
}

/**
 * Files as a place takes them. Videos of one name in folders of their own, as cameras write them
 * (cam1/GX010001.MP4, cam2/GX010001.MP4), are called as these.
 */
export function itemsFor(place: Place, found: Found[]): { items: Item[]; leftOut: string[] } {
  const usable = found.filter((one) => !isHidden(one.path))
  const films = place === 'shot' || place === 'film'
  const twice = (name: string) => usable.filter((one) => one.file.name === name).length > 1
  const items: Item[] = []
  const leftOut: string[] = []
  for (const { file, path } of usable) {
    const parts = path.split('/')
    const folder = parts.at(-2)
    if (!films) items.push({ file, name: file.name })
    else if (isFilm(path))
      items.push({
        file,
        name: folder && twice(file.name) ? `${folder}.${endingOf(path)}` : file.name,
      })
    else if (isPicture(path) && folder) items.push({ file, name: pictureName(parts) })
    else leftOut.push(path)
  }
  return { items, leftOut }
}

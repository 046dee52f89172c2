// Files for poses before they are sent: which pose each folder goes to, and what becomes of names
// that are there already.
import { byPose, joined, sorted } from '../new_project/files'
import type { Found, LeftOut, Photo } from '../new_project/files'
import { asName, kScan } from '../new_project/rows'

/** What becomes of a photograph whose name another one has. */
export type Same = 'replace' | 'both' | 'skip'

export interface Group {
  /** the folder's name, or '' for loose files */
  folder: string
  photos: Photo[]
  leftOut: LeftOut[]
  /** a pose, or '' for a new one */
  target: string
  /** of the new pose */
  name: string
}

/** Folders called like a pose go to it; of others, one alone or loose files go to `current`. */
export function groupsOf(found: Found[], poses: string[], current: string): Group[] {
  const folders = [...byPose(found)].filter(([, files]) => {
    const { photos, leftOut } = sorted(files)
    return photos.length + leftOut.length > 0
  })
  return folders.map(([folder, files]) => {
    const { photos, leftOut } = sorted(files)
    const own = poses.find((pose) => pose.toLowerCase() === asName(folder).toLowerCase())
    const alone = folder === '' || folders.length === 1
    const target = own ?? (alone ? current : '')
    return { folder, photos: joined([], photos), leftOut, target, name: asName(folder) }
  })
}

/** "IMG_7.jpg" beside another one: "IMG_7-2.jpg". */
export function freeName(name: string, taken: Set<string>): string {
  if (!taken.has(name)) return name
  const dot = name.lastIndexOf('.')
  for (let i = 2; ; ++i) {
    const other = `${name.slice(0, dot)}-${i}${name.slice(dot)}`
    if (!taken.has(other)) return other
  }
}

export interface Sent {
  pose: string
  name: string
  file: File
  /** the photograph whose place it takes, or '' */
  replaces: string
}

/** What is sent of a group. @param there  names of the pose's photographs */
export function sentOf(group: Group, there: string[], same: Same): Sent[] {
  const taken = new Set(there)
  const pose = group.target || group.name
  return group.photos.flatMap(({ name, file }) => {
    if (!taken.has(name)) return [{ pose, name, file, replaces: '' }]
    if (same === 'skip') return []
    if (same === 'replace') return [{ pose, name, file, replaces: name }]
    const free = freeName(name, taken)
    taken.add(free)
    return [{ pose, name: free, file, replaces: '' }]
  })
}

export const isFew = (photographs: number): boolean => photographs < kScan

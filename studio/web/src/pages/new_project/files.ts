// What was dropped or chosen, as photographs of poses; the rest is told, never sent.

/** What the server takes, as core/io/pictures/photograph_files.cpp says. */
const kPhotographs = 'jpg jpeg jfif png tif tiff heic heif hif'.split(' ')
/** What a camera writes beside or instead of them. */
const kRaw = 'dng cr2 cr3 nef arw raf orf rw2'.split(' ')
const kOtherPictures = 'webp avif bmp gif psd ppm pgm pbm pnm jxl jp2 tga exr hdr'.split(' ')
/** Kinds that a browser cannot draw as thumbnails. */
const kUndrawn = 'tif tiff heic heif hif'.split(' ')

export const kAccept = kPhotographs.map((kind) => `.${kind}`).join(',')

export interface Found {
  file: File
  /** below what was dropped: "rest/IMG_1.jpg" */
  path: string
}
export interface LeftOut {
  path: string
  why: string
}
export interface Photo {
  /** unique within its pose */
  name: string
  file: File
}

export function kindOf(name: string): string {
  const dot = name.lastIndexOf('.')
  return dot > 0 ? name.slice(dot + 1).toLowerCase() : ''
}
export const isDrawn = (name: string): boolean => !kUndrawn.includes(kindOf(name))

const nameOf = (path: string) => path.split('/').pop() ?? path
const isLitter = (name: string) =>
  name.startsWith('.') || name === 'Thumbs.db' || name === 'desktop.ini'

/** A folder's reader gives its entries a hundred at a time, until it gives none. */
function entriesOf(folder: FileSystemDirectoryEntry): Promise<FileSystemEntry[]> {
  const reader = folder.createReader()
  return new Promise((resolve, reject) => {
    const all: FileSystemEntry[] = []
    const more = () =>
      reader.readEntries((some) => {
        if (some.length === 0) return resolve(all)
        all.push(...some)
        more()
      }, reject)
    more()
  })
}

async function walk(entry: FileSystemEntry, below: string): Promise<Found[]> {
  const path = below + entry.name
  if (entry.isFile) {
    const file = await new Promise<File>((resolve, reject) =>
      (entry as FileSystemFileEntry).file(resolve, reject),
    )
    return [{ file, path }]
  }
  const found: Found[] = []
  for (const one of await entriesOf(entry as FileSystemDirectoryEntry))
    found.push(...(await walk(one, `${path}/`)))
  return found
}

/** Must be called within the drop event: the items are gone after it. */
export function dropped(data: DataTransfer): Promise<Found[]> {
  const entries = [...data.items].map((item) => item.webkitGetAsEntry())
  const plain = [...data.files].map((file) => ({ file, path: file.name }))
  if (!entries.some((entry) => entry !== null)) return Promise.resolve(plain)
  return Promise.all(
    entries.filter((entry) => entry !== null).map((entry) => walk(entry, '')),
  ).then((lists) => lists.flat())
}

export function chosen(files: FileList | null): Found[] {
  return [...(files ?? [])].map((file) => ({ file, path: file.webkitRelativePath || file.name }))
}

function whyNot(kind: string): string {
  if (kRaw.includes(kind)) return 'RAW files go into the pose’s folder by hand; Run develops them'
  if (kOtherPictures.includes(kind)) return 'save it as JPEG or PNG'
  return kind ? `.${kind} is no photograph` : 'no photograph'
}

/** Photographs and what is left out, with the reason; files of the system are not worth a word. */
export function sorted(found: Found[]): { photos: Found[]; leftOut: LeftOut[] } {
  const photos: Found[] = []
  const leftOut: LeftOut[] = []
  for (const one of found) {
    const kind = kindOf(one.path)
    if (isLitter(nameOf(one.path))) continue
    if (one.path.split('/').slice(0, -1).includes('masks'))
      leftOut.push({ path: one.path, why: 'masks are mended on the page Poses' })
    else if (!kPhotographs.includes(kind)) leftOut.push({ path: one.path, why: whyNot(kind) })
    else if (one.file.size === 0) leftOut.push({ path: one.path, why: 'it is empty' })
    else photos.push(one)
  }
  const order = new Intl.Collator('en', { numeric: true })
  photos.sort((a, b) => order.compare(a.path, b.path))
  return { photos, leftOut }
}

const sameFile = (one: File, other: File) =>
  one.size === other.size && one.lastModified === other.lastModified

/** Adds photographs; equal names of other folders get the folder's name before theirs. */
export function joined(old: Photo[], found: Found[]): Photo[] {
  const all = new Map(old.map((photo) => [photo.name, photo]))
  for (const { file, path } of found) {
    const parts = path.split('/')
    let name = file.name
    const there = all.get(name)
    if (there && sameFile(there.file, file)) continue // dropped twice
    if (there) name = parts.slice(-2).join('-')
    for (let i = 2; all.has(name); ++i) name = `${i}-${file.name}`
    all.set(name, { name, file })
  }
  return [...all.values()]
}

/** Folders that hold photographs themselves, by name: each can be a pose. '' for loose files. */
export function byPose(found: Found[]): Map<string, Found[]> {
  const folders = new Map<string, Found[]>()
  for (const one of found) {
    const folder = one.path.split('/').slice(-2, -1)[0] ?? ''
    folders.set(folder, [...(folders.get(folder) ?? []), one])
  }
  return folders
}

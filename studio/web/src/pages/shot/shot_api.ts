// The filmed shot, as the server tells of it. docs/studio-api.md describes each request.
import { get, send } from '../../api'

/** A pixel of a film's frame and the place on the mesh that it shows: one of two ways to say it. */
export interface Click {
  name?: string
  frame: number
  pixel: [number, number]
  face?: number
  barycentric?: [number, number, number]
  vertex?: number
}
export interface Clicks {
  /** hash of the file; sent back with each change */
  revision: string
  clicks: Click[]
  /** what is wrong with the file, or '' */
  problem: string
}

export interface Show {
  frame: number
  pose: string
}
export type CameraKind = 'still' | 'moving'
export interface Film {
  /** folder, as pipeline.yaml has it */
  film: string
  fps: number
  plate: string
  mattes: string
  clicks: string
  holdout: string
  /** a mesh of props */
  set: string
  camera: CameraKind
  shows: Show[]
  frames: { frame: number; name: string }[]
  width: number
  height: number
  /** why the film cannot be read, or '' */
  problem: string
}

export interface LocatedFrame {
  frame: number
  pose: string
  method: string
  contour_px: number | null
  iou: number | null
  inliers: number | null
}
/** As `locate` reports it; null where it does not say. */
export interface Measured {
  /** how well the pictures alone show the focal length, over it */
  focal_seen: number | null
  /** one place of the character fits all frames */
  one_place: boolean | null
  /** the largest change between neighbouring frames of one pose */
  jitter_px: number | null
  /** of a moving camera: how far it is from a smooth way */
  camera_jitter_px: number | null
}
export interface Located {
  width: number
  height: number
  focal_px: number
  /** 'exif', 'solved', 'given', 'kept' */
  focal: string
  focal_uncertainty: number
  still: boolean
  measured: Measured
  has_picture: boolean
  frames: LocatedFrame[]
}

export interface Picture {
  picture: number
  kind: 'filmed' | 'between' | 'held'
  film?: string
  frame: number
}
export interface Join {
  picture: number
  pose: string
  psnr_db: number
  edge_px: number
  edge_share: number
  colour_levels: number
}
export interface Finished {
  fps: number
  width: number
  height: number
  pictures: Picture[]
  joins: Join[]
  has_plate: boolean
  /** pictures with a comparison of filmed and rendered */
  compared: number[]
  /** below out/, or '' */
  video: string
}

/** Of the project: what may be a part of the shot. Paths, but for folders. */
export interface Offers {
  folders: { path: string; pictures: number }[]
  videos: string[]
  pictures: string[]
  meshes: string[]
}

/** The camera of one frame, by its clicks alone. */
export interface Quick {
  frame: number
  /** of the answer; its picture has the same */
  number: number
  seconds: number
  /** why there is none, or '' */
  problem: string
  focal_px?: number
  focal?: string
  contour_px?: number | null
  iou?: number | null
}

/** What pipeline.yaml says of the shot; parts that are left out stay as they are. */
export interface ShotChange {
  film: string
  fps: number
  shows: Show[]
  plate?: string
  mattes?: string
  holdout?: string
  set?: string
  camera?: CameraKind
}

export interface Shot {
  /** of pipeline.yaml */
  revision: string
  /** null: the project has no filmed shot */
  shot: Film | null
  offers: Offers
  clicks: Clicks | null
  located: Located | null
  finished: Finished | null
}

const q = (values: Record<string, string | number>): string =>
  new URLSearchParams(
    Object.entries(values).map(([name, value]): [string, string] => [name, String(value)]),
  ).toString()

export const shotApi = {
  shot: () => get<Shot>('/api/shot'),
  save: (change: ShotChange & { revision: string }) => send<Shot>('PUT', '/api/shot', change),
  /** A video as numbered pictures beside it. */
  cut: (video: string) =>
    send<{ folder: string; pictures: number; fps: number }>('POST', '/api/shot/cut', { video }),
  quick: (frame: number) => send<Quick>('POST', '/api/shot/quick', { frame }),
  saveClicks: (clicks: readonly Click[], revision: string) =>
    send<Shot>('PUT', '/api/shot/clicks', { clicks, revision }),
  /** width 0: full size. `of` is only there so that another film has other addresses. */
  frameUrl: (frame: number, width: number, of: string) =>
    `/api/shot/frame?${q({ frame, width, of })}`,
  /** `version`: a new result has another address */
  pictureUrl: (what: string, number: number, width: number, version: string) =>
    `/api/shot/picture?${q({ what, number, width, version })}`,
}

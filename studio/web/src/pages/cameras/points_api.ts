// Points of known place, and what their clicks made of the cameras (docs/studio-api.md).
import { get, send } from '../../api'

export interface KnownPoint {
  name: string
  /** [m], z up */
  place: [number, number, number]
}
export interface PointClick {
  camera: string
  point: string
  pixel: [number, number]
}
/** What points.json holds, but for its cameras. */
export interface Points {
  points: KnownPoint[]
  clicks: PointClick[]
}
export interface PointCamera {
  name: string
  width: number
  height: number
  /** of its film; 0: one picture is shown */
  frames: number
  /** what is shown of it, in words */
  still: string
  problem: string
}
export interface ClickError {
  point: string
  error_px: number
  /** left out, as the others do not agree with it */
  wrong: boolean
  /** where the calibrated camera sees the point */
  expected: [number, number]
}
export interface CalibrationResult {
  cameras: {
    camera: string
    rms_px: number
    place_error_mm: number
    focal_error: number
    clicks: ClickError[]
  }[]
  points: { point: string; apart_mm: number; cameras: number }[]
  warnings: string[]
  lenses: string
  square_mm: number
  /** points.json has changed since */
  stale: boolean
  /** calibration.yml is another one by now */
  gone: boolean
}
export interface Calibration extends Points {
  revision: string
  problem: string
  cameras: PointCamera[]
  /** folders and files that lenses may come from */
  offers: string[]
  shots: { name: string; calibration: string; ours: boolean }[]
  result: CalibrationResult | null
}

export const pointsApi = {
  read: () => get<Calibration>('/api/calibration'),
  save: ({ points, clicks }: Points, revision: string) =>
    send<Calibration>('PUT', '/api/calibration', { points, clicks, revision }),
  calibrate: (lenses: string, square_mm: number) =>
    send<Calibration>('POST', '/api/calibration/run', { lenses, square_mm }),
  use: (shot: string) => send<Calibration>('POST', '/api/calibration/use', { shot }),
  /** `still`: another picture has another address */
  pictureUrl: ({ name, still }: PointCamera, frame: number, width = 0) => {
    const asked = { camera: name, frame: String(frame), width: String(width), still }
    return `/api/calibration/picture?${new URLSearchParams(asked)}`
  },
}

// What the studio's server tells of earlier results; studio/project/reviews.h has the fields.
import { get, send } from '../../api'

export interface ReviewFile {
  /** below out/ */
  path: string
  /** its address in the cache */
  at: string
  /** of the step that made it */
  title: string
  film: boolean
}

export interface Version {
  id: string
  /** "2026-03-01 14:05:09 UTC", of the run that made it, or '' */
  when: string
  now: boolean
  /** steps whose results were cleaned away */
  gone: string[]
  /** addresses in the cache; '': there is none, or none any more */
  mesh: string
  texture: string
  files: ReviewFile[]
}

export interface Said {
  index: number
  verdict: string
  note: string
  when: string
  /** of what is there now */
  holds: boolean
  /** of what it was said, or '': not there any more */
  version: string
}

export interface Subject {
  /** '': the film */
  pose: string
  /** newest first */
  versions: Version[]
  /** newest first */
  reviews: Said[]
}

export interface Reviews {
  revision: string
  /** why what was said cannot be read, or '' */
  problem: string
  /** a run is at work; its results come when it ends */
  running: boolean
  subjects: Subject[]
}

export interface Figure {
  step: string
  title: string
  key: string
  label: string
  unit: string
  before: number | boolean | null
  after: number | boolean | null
  good: { min?: number; max?: number }
  /** one of the stage's most important ones */
  main: boolean
}

export interface Compared {
  changes: { step: string; title: string; text: string }[]
  /** steps of which one of the two results was cleaned away */
  unknown: string[]
  figures: Figure[]
}

const q = (values: Record<string, string>) => new URLSearchParams(values).toString()
const floats = async (path: string) => {
  const answer = await fetch(path)
  if (!answer.ok) throw new Error(((await answer.json()) as { error: string }).error)
  return answer.arrayBuffer()
}

export const reviewApi = {
  all: () => get<Reviews>('/api/review'),
  compare: (pose: string, before: string, after: string) =>
    get<Compared>(`/api/review/compare?${q({ pose, before, after })}`),
  say: (review: { pose: string; version: string; verdict: string; note: string }, revision: string) =>
    send<Reviews>('POST', '/api/review', { ...review, revision }),
  takeBack: (index: number, revision: string) =>
    send<Reviews>('POST', '/api/review/remove', { index, revision }),
  mesh: (at: string) => floats(`/api/review/mesh?${q({ at })}`),
  /** of each vertex of the mesh to the surface of the other, over its diagonal */
  distance: async (at: string, to: string) =>
    new Float32Array(await floats(`/api/review/distance?${q({ at, to })}`)),
  /** of a texture, a picture or a film; '' where the version has none */
  fileUrl: (at: string | undefined) => (at ? `/api/review/file?${q({ at })}` : ''),
}

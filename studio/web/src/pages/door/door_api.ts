// What the page before all projects asks for. docs/studio-api.md.
import { get, send } from '../../api'

export interface KnownProject {
  folder: string
  name: string
  /** [s since 1970] */
  opened: number
  there: boolean
}

export interface Making {
  kind: string
  folder: string
  at_work: boolean
  share: number
  words: string
  error: string
}

export interface DoorState {
  /** folder of the open project, or '' */
  open: string
  /** where new projects are made */
  home: string
  examples: string[]
  /** where they are made unless another folder is said */
  example_base: string
  making: Making | null
  projects: KnownProject[]
}

export interface ProjectCard {
  state: 'running' | 'done' | 'failed' | 'begun' | 'new' | 'empty' | 'broken'
  done: number
  steps: number
  poses: number
  kind: 'poses' | 'performance'
  /** whether there is one to show */
  picture: boolean
  problem: string
}

const q = (folder: string) => new URLSearchParams({ folder }).toString()
const post = (what: string, body: object = {}) =>
  send<DoorState>('POST', `/api/door/${what}`, body)

export const doorApi = {
  state: () => get<DoorState>('/api/door'),
  open: (folder: string) => post('open', { folder }),
  make: (name: string) => post('new', { name }),
  forget: (folder: string) => post('forget', { folder }),
  example: (kind: string, base: string) => post('example', { kind, base }),
  stopExample: () => post('example/stop'),
  end: () => post('end'),
  address: () => send<{ address: string }>('POST', '/api/door/address', {}),
  card: (folder: string) => get<ProjectCard>(`/api/door/card?${q(folder)}`),
  pictureUrl: (folder: string) => `/api/door/picture?${q(folder)}`,
}

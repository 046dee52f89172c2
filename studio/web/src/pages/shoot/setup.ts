// What a session needs to know before it begins, as the form holds it.
import type { ShootSetup, ShootStory } from '../../api'

export type CameraKind = 'gphoto2' | 'folder' | 'simulated'
export type TableKind = 'none' | 'grbl' | 'steps' | 'simulated'

/** Texts as typed; empty ones too. */
export interface Draft {
  pose: string
  camera: CameraKind
  /** the folder that is watched, or from which the simulated camera takes its photographs */
  folder: string
  table: TableKind
  port: string
  rings: string
  angles: string
  flips: number
  /** flags that few need, by name; absent or '' is the usual */
  more?: Record<string, string>
}

export interface MoreField {
  flag: string
  label: string
  usual: string
  /** the turntable that it is of */
  table?: TableKind
}
export const kMore: MoreField[] = [
  { flag: 'settle', label: 'Rest before a photograph, s', usual: '1' },
  { flag: 'focus-stack', label: 'Photographs with other focus, merged', usual: '1' },
  { flag: 'white-balance', label: 'Grey card: its photograph', usual: 'none' },
  { flag: 'axis', label: 'Axis of the table', usual: 'X', table: 'grbl' },
  { flag: 'degrees-per-unit', label: 'Degrees for one unit', usual: '1', table: 'grbl' },
  { flag: 'speed', label: 'Speed, ° a second', usual: '30', table: 'grbl' },
]
/** Those that are typed, and belong to this table. */
function typedMore({ more = {}, table }: Draft): Record<string, string> {
  const own = kMore.filter((one) => !one.table || one.table === table)
  const typed = own.map((one) => [one.flag, (more[one.flag] ?? '').trim()] as const)
  return Object.fromEntries(typed.filter(([, text]) => text !== ''))
}

export const kFirstDraft: Draft = {
  pose: '',
  camera: 'gphoto2',
  folder: '',
  table: 'none',
  port: '',
  rings: '12, 40',
  angles: '24',
  flips: 0,
}

const kMostAngles = 360
const kMostRings = 12

export function draftOf(setup: ShootSetup): Draft {
  const [camera, ...folder] = setup.camera.split(':')
  const [table, ...port] = setup.turntable.split(':')
  return {
    pose: setup.pose,
    camera: camera as CameraKind,
    folder: folder.join(':'),
    table: table as TableKind,
    port: port.join(':'),
    rings: setup.rings.join(', '),
    angles: String(setup.angles),
    flips: setup.flips,
    ...(setup.more && { more: setup.more }),
  }
}

/** A pose that was begun keeps its plan. */
export function withPlan(draft: Draft, plans: ShootStory['plans']): Draft {
  const plan = plans[draft.pose]
  if (!plan) return draft
  return {
    ...draft,
    rings: plan.rings_deg?.join(', ') ?? draft.rings,
    angles: String(plan.angles ?? draft.angles),
    flips: plan.flips ?? draft.flips,
  }
}

/** Photographs that suffice for a pose into which the template is bent, evenly round the figure. */
export const kSix = 6
export const kFullRing = 24
/** What is proposed for a pose after the first: six, a ring for a scan of its own, or as typed. */
export type Amount = 'six' | 'ring' | 'own'

/** Whether the pose can have few photographs: another one, which has its own, is the template. */
export function offersSix(
  pose: string,
  poses: { name: string; template: boolean; photographs: number }[],
  plans: ShootStory['plans'],
): boolean {
  const own = poses.find((one) => one.name === pose)
  if (own?.template || (own && own.photographs > 0) || pose in plans) return false
  return poses.some((one) => one.template && one.name !== pose && one.photographs > 0)
}

/** The draft with the plan of an amount. @param full  how the template was shot, if that is known */
export function withAmount(
  draft: Draft,
  amount: Amount,
  full: ShootStory['plans'][string] | undefined,
): Draft {
  if (amount === 'own') return draft
  const rings = full?.rings_deg?.join(', ') ?? kFirstDraft.rings
  if (amount === 'six')
    return { ...draft, rings: String(ringsOf(rings)?.[0] ?? 12), angles: String(kSix), flips: 0 }
  const angles = String(full?.angles ?? kFirstDraft.angles)
  return { ...draft, rings, angles, flips: full?.flips ?? 0 }
}

/** "12, 40", "12 40"; null: not numbers, or out of range */
export function ringsOf(text: string): number[] | null {
  const parts = text.split(/[\s,;°]+/).filter((part) => part !== '')
  const rings = parts.map(Number)
  const good = rings.every((ring) => Number.isFinite(ring) && ring >= -90 && ring <= 90)
  return good && rings.length > 0 && rings.length <= kMostRings ? rings : null
}

/** What is wrong with a field, by its name; empty: it can begin. */
export function problemsOf(draft: Draft): Partial<Record<keyof Draft, string>> {
  const problems: Partial<Record<keyof Draft, string>> = {}
  const angles = Number(draft.angles)
  if (!/^[\p{L}\p{M}\p{N}_][\p{L}\p{M}\p{N}_-]*$/u.test(draft.pose))
    problems.pose = draft.pose ? 'Letters, digits, - and _ only.' : 'Name the pose.'
  if (draft.camera === 'folder' && !draft.folder.trim())
    problems.folder = 'Which folder does the other program fill?'
  if ((draft.table === 'grbl' || draft.table === 'steps') && !draft.port.trim())
    problems.port = 'On which port is the turntable?'
  if (!ringsOf(draft.rings)) problems.rings = 'Heights in degrees, such as 12, 40.'
  if (!Number.isInteger(angles) || angles < 3 || angles > kMostAngles)
    problems.angles = `A whole number from 3 to ${kMostAngles}.`
  return problems
}

/** @pre problemsOf(draft) is empty */
export function setupOf(draft: Draft): ShootSetup {
  const folder = draft.folder.trim()
  const port = draft.port.trim()
  const cameras: Record<CameraKind, string> = {
    gphoto2: 'gphoto2',
    folder: `folder:${folder}`,
    simulated: folder ? `simulated:${folder}` : 'simulated',
  }
  const wired = draft.table === 'grbl' || draft.table === 'steps'
  return {
    pose: draft.pose,
    camera: cameras[draft.camera],
    turntable: wired ? `${draft.table}:${port}` : draft.table,
    rings: ringsOf(draft.rings) ?? [],
    angles: Number(draft.angles),
    flips: draft.flips,
    ...(Object.keys(typedMore(draft)).length > 0 && { more: typedMore(draft) }),
  }
}

/** "2 rings × 24 angles: 48 photographs, one each 15°" */
export function summaryOf(draft: Draft): string {
  const rings = ringsOf(draft.rings)?.length ?? 0
  const angles = Number(draft.angles)
  if (Object.keys(problemsOf({ ...draft, pose: 'x', folder: 'x', port: 'x' })).length > 0) return ''
  const lays = draft.flips + 1
  const all = rings * angles * lays
  const each = Math.round(3600 / angles) / 10
  const parts = [rings === 1 ? '1 ring' : `${rings} rings`, `${angles} angles`]
  if (lays > 1) parts.push(`${lays} lays`)
  return `${parts.join(' × ')}: ${all} photographs, one each ${each}°`
}

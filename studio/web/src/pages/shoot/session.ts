// A session of `keypose shoot`, from the events that docs/shoot.md describes.
import type { ShootEvent, ShootStory } from '../../api'

export interface Finding {
  code: string
  words: string
  do: string
}

/** A photograph as the side file has it. */
export interface Entry {
  file: string
  ring: number
  flip: number
  angle_deg: number
  tilt_deg: number
  findings: Finding[]
}

export interface Landed extends Entry {
  /** "r1_a045" */
  name: string
  /** relative to the project */
  path: string
  /** one more each time that it is shot */
  version: number
}

export interface Plan {
  rings_deg: number[]
  angles: number
  flips: number
}

export interface Ask {
  ask: string
  words: string
  do: string
  angle_deg?: number
}

export interface Fault {
  fault: string
  words: string
  do: string
  /** false: the program tries again by itself */
  needs_hand: boolean
}

export interface RingEnd {
  ring: number
  flip: number
  moved_px?: number
  missing_deg: number[]
  findings: Finding[]
}

export type Doing =
  | 'begins'
  | 'turning'
  | 'settling'
  | 'shooting'
  | 'checking'
  | 'asking'
  | 'paused'
  | 'idle'
  | 'ended'

export interface Session {
  running: boolean
  pose: string
  folder: string
  plan: Plan
  done: number
  total: number
  resumed: boolean
  onionPose: string
  /** the template that is bent into the pose's few photographs, or '' */
  bentFrom: string
  /** by name */
  photographs: Record<string, Landed>
  /** names, in the order in which they landed */
  landed: string[]
  skipped: string[]
  rings: RingEnd[]
  doing: Doing
  /** the next photograph, or '' */
  next: string
  ring: number
  flip: number
  angle_deg: number
  tilt_deg: number
  /** the last pose's photograph of the same shot, or '' */
  onion: string
  ask: Ask | null
  fault: Fault | null
  /** the last fault that is over, in words, or '' */
  recovered: string
  /** number of the newest live picture; 0: none yet */
  frame: number
  /** words on the last command that was refused, or '' */
  refused: string
  /** why the session ended, or '' while it runs */
  ended: string
  complete: boolean
  /** it ended by itself, with this error */
  failure: string
}

export const kNoSession: Session = {
  running: false,
  pose: '',
  folder: '',
  plan: { rings_deg: [], angles: 0, flips: 0 },
  done: 0,
  total: 0,
  resumed: false,
  onionPose: '',
  bentFrom: '',
  photographs: {},
  landed: [],
  skipped: [],
  rings: [],
  doing: 'begins',
  next: '',
  ring: 1,
  flip: 0,
  angle_deg: 0,
  tilt_deg: 0,
  onion: '',
  ask: null,
  fault: null,
  recovered: '',
  frame: 0,
  refused: '',
  ended: '',
  complete: false,
  failure: '',
}

type Fields = Record<string, unknown>

function asLanded(name: string, path: string, entry: Fields, version: number): Landed {
  const number = (field: string) => Number(entry[field] ?? 0)
  return {
    name,
    path,
    version,
    file: String(entry.file ?? ''),
    ring: number('ring'),
    flip: number('flip'),
    angle_deg: number('angle_deg'),
    tilt_deg: number('tilt_deg'),
    findings: (entry.findings ?? []) as Finding[],
  }
}

/** The session's start, or its next pose. */
function withPose(before: Session, event: Fields): Session {
  const folder = String(event.folder ?? '')
  const entries = (event.photographs ?? {}) as Record<string, Fields>
  const photographs: Record<string, Landed> = {}
  for (const [name, entry] of Object.entries(entries))
    photographs[name] = asLanded(name, `${folder}/${String(entry.file)}`, entry, 0)
  return {
    ...kNoSession,
    running: true,
    pose: String(event.pose ?? ''),
    folder,
    plan: { ...kNoSession.plan, ...(event.plan as Partial<Plan>) },
    done: Number(event.done ?? 0),
    total: Number(event.total ?? 0),
    resumed: event.resumed === true,
    onionPose: String(event.onion_pose ?? ''),
    bentFrom: String(event.bent_from ?? ''),
    photographs,
    landed: Object.keys(photographs),
    skipped: (event.skipped ?? []) as string[],
    frame: before.frame,
  }
}

function withState(session: Session, event: Fields): Session {
  const doing = event.state as Doing
  const next = String(event.next ?? '')
  // A pause names what was shot last until it is over.
  const isOver = doing === 'paused' && next in session.photographs
  return {
    ...session,
    doing,
    next: isOver ? '' : next,
    ring: Number(event.ring ?? session.ring),
    flip: Number(event.flip ?? session.flip),
    angle_deg: Number(event.angle_deg ?? session.angle_deg),
    tilt_deg: Number(event.tilt_deg ?? session.tilt_deg),
    done: Number(event.done ?? session.done),
    total: Number(event.total ?? session.total),
    onion: String(event.onion ?? ''),
    ask: doing === 'asking' ? session.ask : null,
    recovered: doing === 'turning' ? '' : session.recovered,
  }
}

function withPhotograph(session: Session, event: Fields): Session {
  const name = String(event.photograph)
  const version = (session.photographs[name]?.version ?? 0) + 1
  const one = asLanded(name, String(event.path), event.entry as Fields, version)
  return {
    ...session,
    done: Number(event.done ?? session.done),
    total: Number(event.total ?? session.total),
    photographs: { ...session.photographs, [name]: one },
    landed: [...session.landed.filter((other) => other !== name), name],
    skipped: session.skipped.filter((other) => other !== name),
  }
}

function withFindings(session: Session, event: Fields): Session {
  const photographs = { ...session.photographs }
  for (const [name, findings] of Object.entries(event.photographs as Record<string, Finding[]>))
    if (photographs[name]) photographs[name] = { ...photographs[name], findings }
  return { ...session, photographs }
}

function withRing(session: Session, event: Fields): Session {
  const ring = (event.ring instanceof Object ? event.ring : event) as RingEnd
  const others = session.rings.filter((one) => one.ring !== ring.ring || one.flip !== ring.flip)
  return { ...session, rings: [...others, { ...ring, findings: ring.findings ?? [] }] }
}

/** The session after one more event; events that it does not know change nothing. */
export function afterEvent(session: Session, event: ShootEvent): Session {
  switch (event.event) {
    case 'session':
      return withPose(session, event)
    case 'state':
      return withState(session, event)
    case 'ask':
      return { ...session, doing: 'asking', ask: event as unknown as Ask, refused: '' }
    case 'photograph':
      return withPhotograph(session, event)
    case 'findings':
      return withFindings(session, event)
    case 'ring':
      return withRing(session, event)
    case 'fault':
      return { ...session, fault: event as unknown as Fault, recovered: '' }
    case 'recovered':
      return { ...session, fault: null, recovered: String(event.words ?? '') }
    case 'live':
      return { ...session, frame: Number(event.frame ?? session.frame + 1) }
    case 'accepted':
      return afterAccepted({ ...session, refused: '' }, event)
    case 'refused':
      return { ...session, refused: String(event.words ?? '') }
    case 'ended':
      return {
        ...session,
        doing: 'ended',
        ask: null,
        fault: null,
        ended: String(event.words ?? 'The session has ended.'),
        complete: event.complete === true,
      }
    default:
      return session
  }
}

/** What is skipped is told by no event of its own: it was the next one, or comes back as the id. */
function afterAccepted(session: Session, event: Fields): Session {
  const name = String(event.id ?? session.next)
  if (event.command !== 'skip' || !name || session.skipped.includes(name)) return session
  return { ...session, skipped: [...session.skipped, name] }
}

/** The session that a page finds which is opened in the middle of it. */
export function fromStory(story: ShootStory): Session {
  const session = story.events.reduce(afterEvent, kNoSession)
  return { ...session, running: story.running, failure: story.running ? '' : story.message }
}

/** After the program has ended; `message` is what it said if it failed. */
export function afterEnd(session: Session, message: string): Session {
  return { ...session, running: false, doing: 'ended', ask: null, fault: null, failure: message }
}

// Marks: one file of pairs on the server (docs/studio-api.md), two lists of picks for the page.
import { ask, get, send } from '../../api'
import type { Pick, Picks, Suggestion } from '../../api'
import type { PicksApi } from '../landmarks/pick_files'

/** How the page calls the two sides of a mark, in its sentences. */
export const kBody = 'the actor'
export const kScan = 'the scan'

interface Mark {
  name: string
  source: Pick
  target: Pick
  /** false: a suggestion that nobody has confirmed */
  confirmed: boolean
  confidence: number
}
interface MarkedSide {
  there: boolean
  /** another mesh has another one */
  version: string
  missing: string
}
export interface Marks {
  revision: string
  problem: string
  pairs: Mark[]
  body: MarkedSide
  scan: MarkedSide & { textured?: boolean }
}

export interface MarksApi {
  read(): Promise<Marks>
  save(pairs: { source: Pick; target: Pick }[], revision: string): Promise<Marks>
}

export const marksApi = {
  read: () => get<Marks>('/api/marks'),
  save: (pairs: { source: Pick; target: Pick }[], revision: string) =>
    send<Marks>('PUT', '/api/marks', { pairs, revision }),
  suggest: (count: number) =>
    send<{ pairs: Suggestion[]; why_none: string }>('POST', '/api/marks/suggest', { count }),
  useScan: (scan: string, texture: string) =>
    send<Marks>('POST', '/api/marks/scan', { scan, texture }),
  mesh: async (side: 'body' | 'scan') =>
    (await ask(`/api/marks/mesh?side=${side}`)).arrayBuffer(),
  textureUrl: (version: string) => `/api/marks/texture?version=${version}`,
}

/** The same text for the same picks, in any order and as any program rounds them. */
function signOf(picks: readonly Pick[]): string {
  const lines = picks.map(({ name, face, barycentric }) =>
    JSON.stringify([name, face, barycentric.map((one) => one.toFixed(6))]),
  )
  return lines.sort().join('\n')
}

/**
 * Each side as a file of picks of its own. Pairs of which one half is missing stay here: the
 * server's file has whole ones.
 */
export class MarkSides implements PicksApi {
  private revision = ''
  private saved = ''
  private readonly meant = new Map<string, readonly Pick[]>()
  constructor(
    private readonly api: MarksApi,
    private readonly noted: (marks: Marks) => void,
  ) {}

  async picks(side: string): Promise<Picks> {
    const marks = await this.api.read()
    this.note(marks)
    const whole = marks.pairs.filter((one) => one.confirmed).map((one) => this.sideOf(one, side))
    const names = new Set(whole.map((pick) => pick.name))
    const other = this.meant.get(side === kBody ? kScan : kBody) ?? []
    const halves = (this.meant.get(side) ?? []).filter(
      (pick) => !names.has(pick.name) && !other.some((one) => one.name === pick.name),
    )
    const picks = [...whole, ...halves]
    this.meant.set(side, picks)
    return this.answer(side, picks)
  }

  async savePicks(side: string, picks: Pick[], _revision: string): Promise<Picks> {
    this.meant.set(side, picks)
    const pairs = this.pairs()
    const sign = pairsSign(pairs)
    if (sign !== this.saved) {
      this.note(await this.api.save(pairs, this.revision))
      this.saved = sign
    }
    return this.answer(side, picks)
  }

  savePixels(): Promise<Picks> {
    throw new Error('Marks are not in photographs.')
  }

  private pairs(): { source: Pick; target: Pick }[] {
    const targets = new Map((this.meant.get(kScan) ?? []).map((pick) => [pick.name, pick]))
    return (this.meant.get(kBody) ?? []).flatMap((source) => {
      const target = targets.get(source.name)
      return target ? [{ source, target }] : []
    })
  }

  private sideOf(mark: Mark, side: string): Pick {
    return { ...(side === kBody ? mark.source : mark.target), name: mark.name }
  }

  private note(marks: Marks): void {
    this.revision = marks.revision
    this.saved = pairsSign(marks.pairs.filter((one) => one.confirmed))
    this.noted(marks)
  }

  private answer(side: string, picks: Pick[]): Picks {
    return { pose: side, revision: signOf(picks), picks, problems: [] }
  }
}

function pairsSign(pairs: readonly { source: Pick; target: Pick }[]): string {
  return `${signOf(pairs.map((one) => one.source))}\n\n${signOf(pairs.map((one) => one.target))}`
}

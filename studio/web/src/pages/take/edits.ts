// The changes of a take while it is edited: undo, redo, and what a pull would make. The program
// does them; here is kept which.
import type { Draft } from './take_api'
import type { Between } from './take_model'

/** Changes of one kind within this time are undone together. */
const kOneChange_ms = 900
const kMostKept = 24

/** Lines that are done and undone together. */
export type Change = string[]

export interface Asked {
  /** The take with these lines done, as it would be baked. */
  draft: (lines: string[], between: Between) => Promise<Draft>
  /** Something is to be shown anew. */
  changed: () => void
  /** The last change cannot be done. */
  refused: (error: unknown) => void
  /** Whether to ask again after this error, when the answer comes: nobody was there to refuse. */
  again?: (error: unknown) => Promise<boolean>
  now?: () => number
}

export class Edits {
  done: Change[] = []
  undone: Change[] = []
  /** what is shown; null: nothing yet */
  draft: Draft | null = null
  /** a request is under way */
  busy = false
  /** what stands between recorded frames */
  between: Between = 'hold'
  private preview: string[] = []
  private good: Change[] = []
  private shown = ''
  private last = { tag: '', time: 0 }
  private readonly kept = new Map<string, Draft>()

  constructor(private readonly asked: Asked) {}

  get lines(): string[] {
    return this.done.flat()
  }

  /** Begins with changes that were made before. */
  begin(done: Change[]): void {
    this.done = done
    void this.settle()
  }

  /** `tag`: a change of the same tag soon after takes the place of the one before. */
  change(lines: Change, tag = ''): void {
    const again = tag !== '' && this.continues(tag)
    this.last = { tag, time: this.now() }
    const before = again ? this.done.slice(0, -1) : this.done
    this.done = [...before, lines]
    this.undone = []
    this.preview = []
    void this.settle()
  }

  /** Shows what lines would do, without doing them; empty: ends that. */
  show(lines: string[]): void {
    this.preview = lines
    void this.settle()
  }

  /** Shows it with another way between recorded frames; that is no change of the take. */
  play(between: Between): void {
    this.between = between
    void this.settle()
  }

  /** Whether a change of this tag would take the place of the last one. */
  continues(tag: string): boolean {
    return tag === this.last.tag && this.now() - this.last.time < kOneChange_ms
  }

  /**
   * `saved`, once `done`, is kept elsewhere: nothing is left to be done, unless something was changed
   * meanwhile, also by a pull that is not let go yet. Then all stays, and the answer is false.
   */
  saved(saved: Change[]): boolean {
    if (this.done !== saved || this.preview.length > 0) return false
    this.done = []
    this.undone = []
    this.stepped()
    return true
  }

  undo(): void {
    if (this.done.length === 0) return
    this.undone = [...this.undone, this.done[this.done.length - 1]]
    this.done = this.done.slice(0, -1)
    this.stepped()
  }

  redo(): void {
    if (this.undone.length === 0) return
    this.done = [...this.done, this.undone[this.undone.length - 1]]
    this.undone = this.undone.slice(0, -1)
    this.stepped()
  }

  private stepped(): void {
    this.last.tag = ''
    this.preview = []
    void this.settle()
  }

  private now(): number {
    return (this.asked.now ?? Date.now)()
  }

  private wanted(): string[] {
    return [...this.lines, ...this.preview]
  }

  /** Differs when what is to be shown does. */
  private key(): string {
    return [this.between, ...this.wanted()].join('\n')
  }

  /** Asks until what is wanted is shown; only the newest of what came in meanwhile. */
  private async settle(): Promise<void> {
    this.asked.changed()
    if (this.busy) return
    this.busy = true
    while (this.draft === null || this.shown !== this.key()) {
      const [lines, between, key] = [this.wanted(), this.between, this.key()]
      const done = this.done
      const pulled = this.preview.length > 0
      try {
        const draft = this.kept.get(key) ?? (await this.asked.draft(lines, between))
        this.draft = draft
        this.shown = key
        if (!pulled) this.keep(key, draft, done)
        this.asked.changed()
      } catch (error) {
        if (await this.asked.again?.(error)) continue
        if (!this.giveUp(pulled, error)) break
      }
    }
    this.busy = false
    this.asked.changed()
  }

  private keep(key: string, draft: Draft, done: Change[]): void {
    this.good = done
    this.kept.delete(key)
    this.kept.set(key, draft)
    for (const old of this.kept.keys()) if (this.kept.size > kMostKept) this.kept.delete(old)
  }

  /** Back to the last changes that could be done; false: there are none. */
  private giveUp(pulled: boolean, error: unknown): boolean {
    if (pulled) {
      this.preview = []
      return true
    }
    const hopeless = this.done.length === 0
    this.done = this.done === this.good ? [] : this.good
    this.undone = []
    this.asked.refused(error)
    return !hopeless
  }
}

// Clicks in pictures: what may be done to them, undo, and saving at once. Knows nothing of the page.
import type { Click } from './shot_api'

interface Entry<One> {
  clicks: readonly One[]
  what: string
}

export interface ClickStore<One = Click> {
  /** Writes them; the file's new revision. */
  save(clicks: readonly One[], revision: string): Promise<string>
  /** The file as it is now. */
  read(): Promise<{ clicks: readonly One[]; revision: string }>
}

/** Of a shot, unless said. */
export class ClickFile<One = Click> {
  clicks: readonly One[] = []
  saving = false
  /** why the last change is not in the file, or '' */
  failed = ''
  /** Counts changes made here and ends of their saving: it dates what the server is asked. */
  moment = 0
  private past: Entry<One>[] = []
  private future: Entry<One>[] = []
  private revision = ''
  private dirty = false

  constructor(
    private readonly store: ClickStore<One>,
    private readonly changed: () => void,
    private readonly tell: (words: string) => void,
    private readonly noun = 'clicks',
  ) {}

  get canUndo(): boolean {
    return this.past.length > 0
  }
  get canRedo(): boolean {
    return this.future.length > 0
  }

  /**
   * The file as the server has it. Undo ends here if somebody else has written it.
   * @param asked  `moment` when the server was asked: what it read before a change was written is no news,
   * also when the answer is overtaken by that of the saving
   */
  take(clicks: readonly One[], revision: string, asked = this.moment): void {
    if (asked !== this.moment || this.saving || this.dirty || revision === this.revision) return
    if (this.past.length > 0) this.tell(`The ${this.noun} were changed elsewhere; undo begins anew.`)
    this.clicks = clicks
    this.revision = revision
    this.past = []
    this.future = []
    this.changed()
  }

  change(what: string, clicks: readonly One[]): void {
    this.past = [...this.past, { clicks: this.clicks, what }].slice(-200)
    this.future = []
    this.put(clicks)
  }

  /** What was undone, in words; '' if there was nothing. */
  undo(): string {
    return this.step(this.past, this.future)
  }
  redo(): string {
    return this.step(this.future, this.past)
  }

  private step(from: Entry<One>[], to: Entry<One>[]): string {
    const last = from.pop()
    if (!last) return ''
    to.push({ clicks: this.clicks, what: last.what })
    this.put(last.clicks)
    return last.what
  }

  private put(clicks: readonly One[]): void {
    this.clicks = clicks
    this.dirty = true
    ++this.moment
    this.changed()
    void this.save()
  }

  /** Settles when the file has all changes, or one has failed. */
  async save(): Promise<void> {
    if (this.saving) return
    this.saving = true
    try {
      while (this.dirty) {
        this.dirty = false
        this.revision = await this.store.save(this.clicks, this.revision)
      }
      this.failed = ''
    } catch (error) {
      await this.refused(error)
    } finally {
      this.saving = false
      ++this.moment
      this.changed()
    }
  }

  private async refused(error: unknown): Promise<void> {
    this.dirty = true
    this.failed = error instanceof Error ? error.message : String(error)
    if ((error as { status?: number }).status !== 409) return
    const now = await this.store.read()
    this.dirty = false
    this.clicks = now.clicks
    this.revision = now.revision
    this.past = []
    this.future = []
    this.tell(`The ${this.noun} were changed elsewhere; they were read again.`)
    this.failed = ''
  }
}

/** The first number that no click has as its name. */
export function nextName(clicks: readonly Click[]): string {
  const taken = new Set(clicks.map((click) => click.name))
  for (let number = 1; ; ++number) if (!taken.has(String(number))) return String(number)
}

/** Names of clicks that have none, by their place in the file. */
export const nameOf = (click: Click, index: number): string => click.name || `#${index + 1}`

export const without = (clicks: readonly Click[], index: number): Click[] =>
  clicks.filter((_, i) => i !== index)

export const replaced = (clicks: readonly Click[], index: number, click: Click): Click[] =>
  clicks.map((old, i) => (i === index ? click : old))

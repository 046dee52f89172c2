// Keeps the landmark files of all poses as the page shows them: loads, saves at once, tells of
// changes from outside. One request at a time, so that a revision is never sent twice.
import { ApiError } from '../../api'
import type { PhotoPick, Pick, Picks } from '../../api'
import {
  changed,
  kEmptyHistory,
  redone,
  undone,
  withFile,
  withPhotoPicks,
  withSheetFromOutside,
} from './pick_history'
import type { History, Sheet } from './pick_history'

/** The part of the api that this needs; a test gives its own. */
export interface PicksApi {
  picks(pose: string): Promise<Picks>
  savePicks(pose: string, picks: Pick[], revision: string): Promise<Picks>
  savePixels(pose: string, pixels: PhotoPick[], revision: string): Promise<Picks>
}

interface Saved {
  revision: string
  /** of a pose from few photographs those in photographs; compared by identity */
  picks: readonly Pick[] | readonly PhotoPick[]
  problems: { name: string; text: string }[]
}

const kUnknown: Saved = { revision: '', picks: [], problems: [] }

export class PickFiles {
  history: History = kEmptyHistory
  loaded = false
  saving = false
  /** why the last change is not on disk, or '' */
  failed = ''
  private readonly saved = new Map<string, Saved>()
  constructor(
    private readonly api: PicksApi,
    private readonly onChange: () => void,
    private readonly tell: (text: string) => void,
  ) {}

  problems(pose: string): { name: string; text: string }[] {
    return this.saved.get(pose)?.problems ?? []
  }

  /** Reads files again; what was not yet saved stays. */
  async load(poses: string[]): Promise<void> {
    const answers = await Promise.allSettled(
      poses.map(async (pose) => {
        const before = this.saved.get(pose)
        const file = await this.api.picks(pose)
        // A save may have overtaken this answer; what it brought is newer.
        if (this.saved.get(pose) === before && !this.isUnsaved(pose)) this.take(pose, file)
      }),
    )
    this.loaded = true
    this.onChange()
    // One that has no mesh yet must not keep the others from the page.
    const wrong = answers.find((answer) => answer.status === 'rejected')
    if (wrong) throw wrong.reason
  }

  change(what: string, sheet: Sheet): void {
    this.history = changed(this.history, what, sheet)
    this.onChange()
    void this.save()
  }

  /** What was undone, in words, or ''. */
  undo(): string {
    const what = this.history.past.at(-1)?.what ?? ''
    this.history = undone(this.history)
    this.onChange()
    void this.save()
    return what
  }

  redo(): string {
    const what = this.history.future.at(-1)?.what ?? ''
    this.history = redone(this.history)
    this.onChange()
    void this.save()
    return what
  }

  /** What an import has put into a file; it can be undone. */
  imported(what: string, file: Picks): void {
    const picks = file.picks
    this.saved.set(file.pose, { revision: file.revision, picks, problems: file.problems })
    const files = new Map(this.history.now.files).set(file.pose, picks)
    this.history = changed(this.history, what, { ...this.history.now, files })
    this.onChange()
  }

  revision(pose: string): string {
    return this.saved.get(pose)?.revision ?? ''
  }

  /** Saves until nothing is left to save. */
  async save(): Promise<void> {
    if (this.saving) return this.underWay
    this.underWay = this.saveAll()
    return this.underWay
  }
  private underWay: Promise<void> = Promise.resolve()

  private async saveAll(): Promise<void> {
    this.saving = true
    this.failed = ''
    try {
      for (let pose = this.unsaved(); pose !== null; pose = this.unsaved())
        await this.saveOne(pose)
    } catch (error) {
      this.failed = error instanceof Error ? error.message : String(error)
    } finally {
      this.saving = false
      this.onChange()
    }
  }

  private async saveOne(pose: string): Promise<void> {
    const { files, photos } = this.history.now
    const pixels = photos.get(pose)
    const meant = files.get(pose) ?? []
    const picks = pixels ?? meant
    const revision = this.revision(pose)
    try {
      const answer = pixels
        ? await this.api.savePixels(pose, [...pixels], revision)
        : await this.api.savePicks(pose, [...meant], revision)
      this.saved.set(pose, { revision: answer.revision, picks, problems: answer.problems })
      this.onChange()
    } catch (error) {
      if (!(error instanceof ApiError && error.status === 409)) throw error
      this.take(pose, await this.api.picks(pose))
      this.tell(
        `The landmarks of ${pose} were changed elsewhere. ` +
          'They are shown as they are now, without your last change.',
      )
    }
  }

  private take(pose: string, file: Picks): void {
    const old = this.saved.get(pose) ?? kUnknown
    // By the file's hash: the server's picks may have their fields in another order.
    const same = this.saved.has(pose) && old.revision === file.revision
    const picks = same ? old.picks : (file.pixels ?? file.picks)
    this.saved.set(pose, { revision: file.revision, picks, problems: file.problems })
    if (same && !this.isUnsaved(pose)) return
    const { now } = this.history
    const sheet = file.pixels
      ? withPhotoPicks(now, pose, picks as readonly PhotoPick[])
      : withFile(now, pose, picks as readonly Pick[])
    this.history = withSheetFromOutside(sheet)
  }

  private contentOf(pose: string): readonly Pick[] | readonly PhotoPick[] | undefined {
    const { files, photos } = this.history.now
    return photos.get(pose) ?? files.get(pose)
  }

  private isUnsaved(pose: string): boolean {
    const picks = this.contentOf(pose)
    return picks !== undefined && picks !== this.saved.get(pose)?.picks
  }

  private unsaved(): string | null {
    const { files, photos } = this.history.now
    return [...files.keys(), ...photos.keys()].find((pose) => this.isUnsaved(pose)) ?? null
  }
}

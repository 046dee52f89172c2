// The picks of all poses, what may be done to them, and undo. Knows nothing of the page.
import type { PhotoPick, Pick, Suggestion } from '../../api'

/** Two places that belong together; one side is missing while the pair is open. */
export interface Pair {
  name: string
  template: Pick | null
  pose: Pick | null
}

/** A place of the template, and where photographs of a pose show it. */
export interface PhotoPair {
  name: string
  template: Pick | null
  pixels: readonly PhotoPick[]
}

/** All that one undo takes back. Each part is replaced, never changed in place. */
export interface Sheet {
  /** by pose, the template among them */
  files: ReadonlyMap<string, readonly Pick[]>
  /** of poses from few photographs, which are picked in these, by pose */
  photos: ReadonlyMap<string, readonly PhotoPick[]>
  /** not yet accepted or refused, by pose, surest first */
  suggestions: ReadonlyMap<string, readonly Suggestion[]>
}

interface Entry {
  sheet: Sheet
  what: string
}
export interface History {
  now: Sheet
  past: readonly Entry[]
  future: readonly Entry[]
}

const kLongest = 200

export const kEmptyHistory: History = {
  now: { files: new Map(), photos: new Map(), suggestions: new Map() },
  past: [],
  future: [],
}

/** `what` names the change for the person: "delete a". */
export function changed(history: History, what: string, sheet: Sheet): History {
  if (sheet === history.now) return history
  const past = [...history.past, { sheet: history.now, what }].slice(-kLongest)
  return { now: sheet, past, future: [] }
}

export function undone(history: History): History {
  const last = history.past.at(-1)
  if (!last) return history
  return {
    now: last.sheet,
    past: history.past.slice(0, -1),
    future: [...history.future, { sheet: history.now, what: last.what }],
  }
}

export function redone(history: History): History {
  const next = history.future.at(-1)
  if (!next) return history
  return {
    now: next.sheet,
    past: [...history.past, { sheet: history.now, what: next.what }],
    future: history.future.slice(0, -1),
  }
}

/** A file as someone else wrote it. Undo ends here: it would write over the other's work. */
export function withSheetFromOutside(sheet: Sheet): History {
  return { now: sheet, past: [], future: [] }
}

export function withFile(sheet: Sheet, pose: string, picks: readonly Pick[]): Sheet {
  return { ...sheet, files: new Map(sheet.files).set(pose, picks) }
}

export function withSuggestions(
  sheet: Sheet,
  pose: string,
  suggestions: readonly Suggestion[],
): Sheet {
  const sorted = [...suggestions].sort((one, two) => two.confidence - one.confidence)
  return { ...sheet, suggestions: new Map(sheet.suggestions).set(pose, sorted) }
}

export function picksOf(sheet: Sheet, pose: string): readonly Pick[] {
  return sheet.files.get(pose) ?? []
}

/** Joined by name, in the template's order; what only the pose has comes last. */
export function pairsOf(sheet: Sheet, template: string, pose: string): Pair[] {
  const onPose = new Map(picksOf(sheet, pose).map((pick) => [pick.name, pick]))
  const pairs: Pair[] = []
  for (const pick of picksOf(sheet, template)) {
    pairs.push({ name: pick.name, template: pick, pose: onPose.get(pick.name) ?? null })
    onPose.delete(pick.name)
  }
  for (const [name, pick] of onPose) pairs.push({ name, template: null, pose: pick })
  return pairs
}

/** Puts a pick on a pose; one of the same name moves. */
export function withPick(sheet: Sheet, pose: string, pick: Pick): Sheet {
  const picks = picksOf(sheet, pose)
  const known = picks.some((one) => one.name === pick.name)
  const moved = picks.map((one) => (one.name === pick.name ? pick : one))
  return withFile(sheet, pose, known ? moved : [...picks, pick])
}

/** In every file: the template's picks serve all poses, which are matched by name. */
export function withName(sheet: Sheet, from: string, to: string): Sheet {
  return {
    ...sheet,
    files: renamed(sheet.files, from, to),
    photos: renamed(sheet.photos, from, to),
  }
}

function renamed<T extends { name: string }>(
  files: ReadonlyMap<string, readonly T[]>,
  from: string,
  to: string,
): ReadonlyMap<string, readonly T[]> {
  const next = new Map(files)
  for (const [pose, picks] of files)
    if (picks.some((pick) => pick.name === from))
      next.set(
        pose,
        picks.map((pick) => (pick.name === from ? { ...pick, name: to } : pick)),
      )
  return next
}

/** Poses beside the template and `pose` that have a pick of this name. */
export function otherUsers(sheet: Sheet, template: string, pose: string, name: string): string[] {
  const all: [string, readonly { name: string }[]][] = [...sheet.files, ...sheet.photos]
  return all
    .filter(([other]) => other !== template && other !== pose)
    .filter(([, picks]) => picks.some((pick) => pick.name === name))
    .map(([other]) => other)
}

/** The template keeps its side while other poses need it. */
export function withoutPair(sheet: Sheet, template: string, pose: string, name: string): Sheet {
  const others = (picks: readonly Pick[]) => picks.filter((pick) => pick.name !== name)
  const next = withFile(sheet, pose, others(picksOf(sheet, pose)))
  if (otherUsers(sheet, template, pose, name).length > 0) return next
  return withFile(next, template, others(picksOf(sheet, template)))
}

export function photoPicksOf(sheet: Sheet, pose: string): readonly PhotoPick[] {
  return sheet.photos.get(pose) ?? []
}

export function withPhotoPicks(sheet: Sheet, pose: string, picks: readonly PhotoPick[]): Sheet {
  return { ...sheet, photos: new Map(sheet.photos).set(pose, picks) }
}

/** Puts a pick into a photograph; one of the same name there moves. */
export function withPhotoPick(sheet: Sheet, pose: string, pick: PhotoPick): Sheet {
  const picks = photoPicksOf(sheet, pose)
  const same = (one: PhotoPick) => one.name === pick.name && one.image === pick.image
  const moved = picks.map((one) => (same(one) ? pick : one))
  return withPhotoPicks(sheet, pose, picks.some(same) ? moved : [...picks, pick])
}

/** Without `image`: in all photographs. */
export function withoutPhotoPick(sheet: Sheet, pose: string, name: string, image = ''): Sheet {
  const goes = (one: PhotoPick) => one.name === name && (image === '' || one.image === image)
  return withPhotoPicks(
    sheet,
    pose,
    photoPicksOf(sheet, pose).filter((one) => !goes(one)),
  )
}

/** As withoutPair, of a pose that is picked in photographs. */
export function withoutPhotoPair(
  sheet: Sheet,
  template: string,
  pose: string,
  name: string,
): Sheet {
  const next = withoutPhotoPick(sheet, pose, name)
  if (otherUsers(sheet, template, pose, name).length > 0) return next
  const others = picksOf(sheet, template).filter((pick) => pick.name !== name)
  return withFile(next, template, others)
}

/** Joined by name, in the template's order; what only photographs have comes last. */
export function photoPairsOf(sheet: Sheet, template: string, pose: string): PhotoPair[] {
  const pairs = new Map<string, { template: Pick | null; pixels: PhotoPick[] }>()
  for (const pick of picksOf(sheet, template)) pairs.set(pick.name, { template: pick, pixels: [] })
  for (const pixel of photoPicksOf(sheet, pose)) {
    const pair = pairs.get(pixel.name) ?? { template: null, pixels: [] }
    pair.pixels.push(pixel)
    pairs.set(pixel.name, pair)
  }
  return [...pairs].map(([name, pair]) => ({ name, ...pair }))
}

export function namesOf(sheet: Sheet): Set<string> {
  const all = [...sheet.files.values(), ...sheet.photos.values()]
  return new Set(all.flatMap((picks) => picks.map((pick) => pick.name)))
}

/** The first of a, b, ... z, aa, ab, ... that is free. */
export function nextName(taken: ReadonlySet<string>): string {
  for (let number = 0; ; ++number) {
    const name = lettersOf(number)
    if (!taken.has(name)) return name
  }
}

function lettersOf(number: number): string {
  const last = String.fromCharCode(97 + (number % 26))
  return number < 26 ? last : lettersOf(Math.floor(number / 26) - 1) + last
}

/** A suggestion becomes a pair of ordinary picks. */
export function withAccepted(
  sheet: Sheet,
  template: string,
  pose: string,
  suggestion: Suggestion,
): Sheet {
  const name = nameFor(sheet, pose, suggestion)
  const onTemplate = withPick(sheet, template, { ...suggestion.source, name })
  const onBoth = withPick(onTemplate, pose, { ...suggestion.target, name })
  return withRefused(onBoth, pose, suggestion)
}

export function withRefused(sheet: Sheet, pose: string, suggestion: Suggestion): Sheet {
  const left = (sheet.suggestions.get(pose) ?? []).filter((one) => one !== suggestion)
  return { ...sheet, suggestions: new Map(sheet.suggestions).set(pose, left) }
}

/** Its own name where that says something: an open pair of the template that it completes. */
function nameFor(sheet: Sheet, pose: string, suggestion: Suggestion): string {
  const told = suggestion.name
  const madeUp = told === '' || told.startsWith('suggested')
  const onPose = picksOf(sheet, pose).some((pick) => pick.name === told)
  return madeUp || onPose ? nextName(namesOf(sheet)) : told
}

// Landmarks of one half of a symmetric figure, for the other half: their names, and where they go.
import type { Mirrored, Suggestion } from '../../api'
import { namesOf, picksOf, withPick, withSuggestions } from './pick_history'
import type { Sheet } from './pick_history'

const kWords: [string, string][] = [
  ['left', 'right'],
  ['Left', 'Right'],
  ['LEFT', 'RIGHT'],
]
const kLetters: Record<string, string> = { l: 'r', L: 'R', r: 'l', R: 'L' }

/** "left hand" for "right hand", "foot.L" for "foot.R"; else "nose mirrored". */
export function mirroredName(name: string): string {
  for (const [left, right] of kWords) {
    if (name.includes(left)) return name.replace(left, right)
    if (name.includes(right)) return name.replace(right, left)
  }
  const letter = /(^|[ _.-])([LlRr])(?=$|[ _.-])/
  if (letter.test(name)) return name.replace(letter, (_, before, one) => before + kLetters[one])
  return `${name} mirrored`
}

/** Beyond it the net does not lie on the scan there, so that the place is a guess. */
const kFar = 0.02

/**
 * With the pose's net each becomes a suggestion, to be looked at; without, it stands on the
 * template, and waits for its place on the pose.
 */
export function withMirrored(
  sheet: Sheet,
  template: string,
  pose: string,
  mirrored: readonly Mirrored[],
): { sheet: Sheet; suggested: number; open: number } {
  const suggestions: Suggestion[] = [...(sheet.suggestions.get(pose) ?? [])]
  const taken = new Set([...namesOf(sheet), ...suggestions.map((one) => one.name)])
  let next = sheet
  let suggested = 0
  let open = 0
  for (const { of, source, target, off } of mirrored) {
    const name = mirroredName(of)
    if (taken.has(name) || !picksOf(sheet, template).some((pick) => pick.name === of)) continue
    taken.add(name)
    const confidence = Math.max(0.3, 0.9 - (0.5 * off) / kFar)
    if (target) {
      const pick = { ...target, name }
      suggestions.push({ name, source: { ...source, name }, target: pick, confidence })
      ++suggested
    } else {
      next = withPick(next, template, { ...source, name })
      ++open
    }
  }
  return { sheet: withSuggestions(next, pose, suggestions), suggested, open }
}

// Which markers a view shows, and what each of them stands for.
import type { Advice, Pick, Suggestion } from '../../api'
import type { Marker, Viewer } from '../../view/viewer'
import { percent } from '../../words'
import type { Pair } from './pick_history'

export type Side = 'template' | 'pose'

/** One row of the lists and its markers. */
export type Item =
  | { id: string; kind: 'pair'; pair: Pair }
  | { id: string; kind: 'suggestion'; suggestion: Suggestion; number: number }

export interface Pending {
  side: Side
  pick: Pick
}

/** A marker, with the id of its item; '' for the pending pick, 'advice:N' for an advice. */
export interface Meaning {
  marker: Marker
  id: string
}

export const kAdviceSigns = ['①', '②', '③']

export function itemsOf(suggestions: readonly Suggestion[], pairs: Pair[]): Item[] {
  return [
    ...suggestions.map((suggestion, i): Item => ({
      id: `suggestion:${suggestion.name}`,
      kind: 'suggestion',
      suggestion,
      number: i + 1,
    })),
    ...pairs.map((pair): Item => ({ id: `pair:${pair.name}`, kind: 'pair', pair })),
  ]
}

/** The item's pick on a side. */
export function pickOn(item: Item, side: Side): Pick | null {
  if (item.kind === 'pair') return item.pair[side]
  return side === 'template' ? item.suggestion.source : item.suggestion.target
}

export function labelOf(item: Item): string {
  if (item.kind === 'pair') return item.pair.name
  return `${item.number} · ${percent(item.suggestion.confidence)}`
}

function kindOf(item: Item, chosen: string, problems: Set<string>): Marker['kind'] {
  if (item.id === chosen) return 'chosen'
  if (item.kind === 'suggestion') return 'suggested'
  return problems.has(item.pair.name) ? 'problem' : 'landmark'
}

export function markersOf(
  side: Side,
  viewer: Viewer,
  shown: {
    items: Item[]
    chosen: string
    problems: Set<string>
    pending: Pending | null
    advice: Advice[]
  },
): Meaning[] {
  const found: Meaning[] = []
  for (const item of shown.items) {
    const pick = pickOn(item, side)
    if (!pick) continue
    const place = viewer.placeOf(pick.face, pick.barycentric)
    const kind = kindOf(item, shown.chosen, shown.problems)
    found.push({ id: item.id, marker: { name: labelOf(item), place, kind } })
  }
  if (shown.pending?.side === side) {
    const { name, face, barycentric } = shown.pending.pick
    const place = viewer.placeOf(face, barycentric)
    found.push({ id: '', marker: { name: `${name} …`, place, kind: 'chosen' } })
  }
  if (side === 'template')
    shown.advice.slice(0, kAdviceSigns.length).forEach((advice, i) => {
      const marker: Marker = { name: kAdviceSigns[i], place: advice.place, kind: 'advice' }
      found.push({ id: `advice:${i}`, marker })
    })
  return found
}

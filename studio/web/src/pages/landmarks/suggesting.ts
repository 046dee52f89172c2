// Suggestions: asked for, then accepted or refused one by one.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import type { Suggestion } from '../../api'
import { useStudio } from '../../state'
import { count } from '../../words'
import type { Item } from './markers'
import type { PickFiles } from './pick_files'
import { withMirrored } from './mirroring'
import { withAccepted, withRefused, withSuggestions } from './pick_history'

/** What the server found; `why_none` says why there is nothing, and what to do. */
export interface Found {
  pairs: Suggestion[]
  why_none: string
}

/** The part of the page's choice that this needs. */
interface Choice {
  item: Item | null
  setChosen: (id: string) => void
  chooseAfter: (gone: Item) => void
}

export function useSuggestions(
  files: PickFiles,
  template: string,
  pose: string,
  choice: Choice,
  find: () => Promise<Found>,
) {
  const { tell, complain } = useStudio()
  const [searching, setSearching] = useState(false)
  const [whyNone, setWhyNone] = useState('')
  const sheet = files.history.now

  const suggest = async () => {
    setSearching(true)
    setWhyNone('')
    try {
      await files.save()
      const found = await find()
      // Into the sheet as it is by now: the search takes a while.
      const next = withSuggestions(files.history.now, pose, found.pairs)
      files.change(count(found.pairs.length, 'suggestion'), next)
      const first = next.suggestions.get(pose)?.[0]
      if (first) choice.setChosen(`suggestion:${first.name}`)
      else setWhyNone(found.why_none || 'No place was found that looks alike on both.')
    } catch (error) {
      complain(error)
    } finally {
      setSearching(false)
    }
  }
  const mirror = async () => {
    setSearching(true)
    try {
      await files.save()
      const { mirrored } = await api.mirroredPicks(pose)
      const made = withMirrored(files.history.now, template, pose, mirrored)
      const all = made.suggested + made.open
      if (all === 0) return tell('Each landmark has its partner on the other half already.')
      files.change(`mirror ${count(all, 'landmark')}`, made.sheet)
      const first = made.suggested > 0 ? made.sheet.suggestions.get(pose)?.[0] : undefined
      if (first) choice.setChosen(`suggestion:${first.name}`)
      else tell(`${count(all, 'landmark')} mirrored on ${template}; now click their places on ${pose}.`)
    } catch (error) {
      complain(error)
    } finally {
      setSearching(false)
    }
  }
  const decide = (take: boolean, item: Item | null = choice.item) => {
    if (item?.kind !== 'suggestion') return
    const { suggestion } = item
    const next = take
      ? withAccepted(sheet, template, pose, suggestion)
      : withRefused(sheet, pose, suggestion)
    files.change(take ? 'accept a suggestion' : 'refuse a suggestion', next)
    choice.chooseAfter(item)
  }
  const acceptAbove = (least: number) => {
    const sure = (sheet.suggestions.get(pose) ?? []).filter((one) => one.confidence > least)
    const next = sure.reduce((old, one) => withAccepted(old, template, pose, one), sheet)
    files.change(`accept ${count(sure.length, 'suggestion')}`, next)
    choice.setChosen('')
  }
  const refuseAll = () =>
    files.change('refuse all suggestions', withSuggestions(sheet, pose, []))
  return { searching, whyNone, suggest, mirror, decide, acceptAbove, refuseAll }
}

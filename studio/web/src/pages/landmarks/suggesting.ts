// Suggestions: asked for, then accepted or refused one by one.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import { useStudio } from '../../state'
import { count } from '../../words'
import type { Item } from './markers'
import type { PickFiles } from './pick_files'
import { withAccepted, withRefused, withSuggestions } from './pick_history'

const kSuggestions = 12

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
) {
  const { tell, complain } = useStudio()
  const [searching, setSearching] = useState(false)
  const sheet = files.history.now

  const suggest = async () => {
    setSearching(true)
    try {
      await files.save()
      const found = await api.suggest(pose, kSuggestions)
      // Into the sheet as it is by now: the search takes a while.
      const next = withSuggestions(files.history.now, pose, found)
      files.change(count(found.length, 'suggestion'), next)
      const first = next.suggestions.get(pose)?.[0]
      if (first) choice.setChosen(`suggestion:${first.name}`)
      else tell('No place was found that looks alike on both.')
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
  return { searching, suggest, decide, acceptAbove, refuseAll }
}

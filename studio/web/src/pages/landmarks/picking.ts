// What can be done with picks on the page: choose, begin and complete pairs, rename, delete.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Advice, Pick, Pose } from '../../api'
import { useStudio } from '../../state'
import { useUnsavedGuard } from '../poses/route'
import type { Hit } from '../../view/viewer'
import { adviceOnFace, lookAt, lookAtAdvice } from './looking'
import type { Surfaces } from './looking'
import { itemsOf } from './markers'
import type { Item, Pending, Side } from './markers'
import { PickFiles } from './pick_files'
import {
  namesOf,
  nextName,
  otherUsers,
  pairsOf,
  withName,
  withoutPair,
  withPick,
} from './pick_history'
import type { Sheet } from './pick_history'
import { useSuggestions } from './suggesting'
import type { Found } from './suggesting'

export type Place = Omit<Pick, 'name'>

const kSaid_ms = 4000

/** Whether it has the mesh on which landmarks are picked. */
const canBePicked = (pose: Pose): boolean =>
  pose.meshes.includes(pose.template ? 'mesh' : 'clean')

export const placeOf = (hit: Hit): Place => ({ face: hit.face, barycentric: hit.barycentric })

/** The files of all poses, loaded again whenever the project changes. */
export function usePickFiles(): PickFiles {
  const { project, version, tell, complain } = useStudio()
  const [, redraw] = useState(0)
  const files = useMemo(
    () => new PickFiles(api, () => redraw((old) => old + 1), tell),
    [tell],
  )
  // A pose without a mesh has no landmarks to load, and that is no fault.
  const picked = project.poses.filter((pose) => pose.method === 'fit' || canBePicked(pose))
  const names = picked.map((pose) => pose.name).join('\n')
  useEffect(() => {
    const load = async () => {
      await files.load(names ? names.split('\n') : [])
      // A change that could not be saved, perhaps as the studio was away, is tried again.
      if (files.failed) await files.save()
    }
    load().catch(complain)
  }, [files, names, version, complain])
  useUnsavedGuard(files.failed !== '')
  return files
}

/** Words by name, of both files. */
export function problemsOf(files: PickFiles, poses: string[]): Map<string, string> {
  const words = new Map<string, string>()
  for (const pose of poses)
    for (const { name, text } of files.problems(pose))
      words.set(name, words.has(name) ? `${words.get(name)} ${text}` : text)
  return words
}

/** Words on what was just done, for a few seconds. */
export function useSaid(): [string, (words: string) => void] {
  const [said, setSaid] = useState('')
  useEffect(() => {
    if (said === '') return
    const timer = setTimeout(() => setSaid(''), kSaid_ms)
    return () => clearTimeout(timer)
  }, [said])
  return [said, setSaid]
}

/** Which row is chosen, and the ways through the list. */
function useChoice(items: Item[], problems: Map<string, string>, surfaces: Surfaces) {
  const [chosen, setChosen] = useState('')
  const at = items.findIndex((one) => one.id === chosen)
  const item = items[at] ?? null
  const choose = (next: Item | undefined) => {
    setChosen(next?.id ?? '')
    if (next) lookAt(surfaces, next, false)
  }
  const step = (by: number) => {
    const from = at < 0 && by < 0 ? items.length : at
    choose(items[Math.min(items.length - 1, Math.max(0, from + by))])
  }
  const wants = (one: Item) =>
    one.kind === 'suggestion' ||
    !one.pair.template ||
    !one.pair.pose ||
    problems.has(one.pair.name)
  /** The next that wants a decision; if none does, the next one. */
  const next = () => {
    const around = [...items.slice(at + 1), ...items.slice(0, Math.max(0, at))]
    choose(around.find(wants) ?? around[0] ?? item)
  }
  /** The one that takes the place of a removed one. */
  const chooseAfter = (gone: Item) => {
    const place = items.indexOf(gone)
    const heir = items[place + 1] ?? items[place - 1]
    choose(heir?.kind === gone.kind ? heir : undefined)
  }
  const focus = () => {
    if (item) lookAt(surfaces, item, true)
  }
  return { chosen, setChosen, item, choose, step, next, chooseAfter, focus }
}

/** Pairs that begin on one side and are completed on the other. */
function usePairing(
  files: PickFiles,
  nameOf: Record<Side, string>,
  open: Item | null,
  setChosen: (id: string) => void,
) {
  const { tell } = useStudio()
  const sheet = files.history.now
  const [pending, setPending] = useState<Pending | null>(null)
  const [typed, setTyped] = useState('')
  const auto = nextName(namesOf(sheet))

  const begin = (side: Side, place: Place) => {
    const wanted = typed.trim()
    const free = wanted !== '' && !namesOf(sheet).has(wanted)
    if (wanted !== '' && !free) tell(`'${wanted}' is taken; this landmark is called ${auto}.`)
    setPending({ side, pick: { ...place, name: free ? wanted : auto } })
    setChosen('')
  }
  const complete = (side: Side, place: Place, first: Pending) => {
    const { name } = first.pick
    const half = withPick(sheet, nameOf[first.side], first.pick)
    files.change(`pair ${name}`, withPick(half, nameOf[side], { ...place, name }))
    setPending(null)
    setTyped('')
    setChosen(`pair:${name}`)
  }
  const put = (what: string, name: string, side: Side, place: Place) =>
    files.change(`${what} ${name}`, withPick(sheet, nameOf[side], { ...place, name }))
  const pick = (side: Side, hit: Hit) => {
    const place = placeOf(hit)
    if (pending && pending.side !== side) complete(side, place, pending)
    else if (pending) setPending({ side, pick: { ...place, name: pending.pick.name } })
    else if (open?.kind === 'pair' && !open.pair[side]) put('place', open.pair.name, side, place)
    else begin(side, place)
  }
  const move = (side: Side, item: Item | null, hit: Hit) => {
    if (item?.kind === 'pair') put('move', item.pair.name, side, placeOf(hit))
    else if (!item && pending)
      setPending({ side, pick: { ...placeOf(hit), name: pending.pick.name } })
  }
  return { pending, setPending, typed, setTyped, auto, begin, pick, move }
}

/** Names and ends of pairs. */
function useEdits(
  files: PickFiles,
  template: string,
  pose: string,
  choice: ReturnType<typeof useChoice>,
) {
  const { tell, complain } = useStudio()
  const [renaming, setRenaming] = useState('')
  const sheet: Sheet = files.history.now
  const rename = (from: string, to: string) => {
    setRenaming('')
    const name = to.trim()
    if (name === '' || name === from) return
    if (namesOf(sheet).has(name)) return complain(`A landmark is already called '${name}'.`)
    files.change(`rename ${from}`, withName(sheet, from, name))
    choice.setChosen(`pair:${name}`)
  }
  const remove = (item: Item | null = choice.item) => {
    if (item?.kind !== 'pair') return
    const { name } = item.pair
    const users = otherUsers(sheet, template, pose, name)
    const verb = users.length === 1 ? 'uses' : 'use'
    if (users.length > 0)
      tell(`${name} stays on ${template}: ${users.join(', ')} also ${verb} it.`)
    if (users.length > 0 && !item.pair.pose) return
    files.change(`delete ${name}`, withoutPair(sheet, template, pose, name))
    if (users.length === 0) choice.chooseAfter(item)
  }
  return { renaming, setRenaming, rename, remove }
}

export type Picking = ReturnType<typeof usePicking>

/** @param find  looks for suggestions */
export function usePicking(
  files: PickFiles,
  surfaces: Surfaces,
  advice: Advice[],
  find: () => Promise<Found>,
) {
  const template = surfaces.template.name
  const pose = surfaces.pose.name
  const sheet = files.history.now
  const items = itemsOf(sheet.suggestions.get(pose) ?? [], pairsOf(sheet, template, pose))
  const problems = problemsOf(files, [template, pose])
  const choice = useChoice(items, problems, surfaces)
  const pairing = usePairing(files, { template, pose }, choice.item, choice.setChosen)
  const edits = useEdits(files, template, pose, choice)
  const suggestions = useSuggestions(files, template, pose, choice, find)
  const [said, setSaid] = useSaid()
  useEffect(() => setSaid(''), [choice.chosen, pairing.pending])
  useEffect(() => {
    pairing.setPending(null)
    edits.setRenaming('')
    choice.setChosen('')
  }, [pose])

  const latest = useRef(items)
  latest.current = items
  const itemOf = (id: string) => latest.current.find((one) => one.id === id) ?? null
  const undo = () => {
    if (pairing.pending) return pairing.setPending(null)
    const what = files.undo()
    if (what) setSaid(`Undone: ${what}.`)
  }
  const redo = () => {
    const what = files.redo()
    if (what) setSaid(`Done again: ${what}.`)
  }
  const cancel = () => {
    if (pairing.pending) pairing.setPending(null)
    else choice.setChosen('')
  }
  /** Begins a pair just where the advice is. */
  const takeAdvice = (index: number) => {
    const { data } = surfaces.template
    const place = data && advice[index] ? adviceOnFace(data, advice[index]) : null
    if (place) pairing.begin('template', place)
  }
  return {
    ...choice,
    ...pairing,
    ...edits,
    ...suggestions,
    files,
    template,
    pose,
    items,
    problems,
    said,
    itemOf,
    undo,
    redo,
    cancel,
    takeAdvice,
    lookAtAdvice: (index: number) => lookAtAdvice(surfaces.template, advice[index]),
  }
}

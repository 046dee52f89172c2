// Mode 'Pick': template and pose side by side, with the lists of pairs and suggestions.
import type { ComponentChildren } from 'preact'
import { useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Advice, Pose } from '../../api'
import { useStudio } from '../../state'
import type { Hit } from '../../view/viewer'
import { sentence } from '../../words'
import { LookChoice } from './bench_pieces'
import { DropPlace, FilesMenu, useImport } from './files_menu'
import { FitCard } from './fit_card'
import { useKeys } from '../../keys'
import { KeysHelp } from './keys'
import { kSides } from './looking'
import type { Surfaces } from './looking'
import { kAdviceSigns } from './markers'
import type { Side } from './markers'
import { PairList, SuggestionList } from './pair_list'
import { usePickFiles, usePicking } from './picking'
import type { Picking } from './picking'
import { picksOf } from './pick_history'
import { useAdvice, useLinkedTurns, useMarkers } from './pick_views'
import { hitInMiddle, SurfaceStage, useSurface, wholeView } from './surface'

const kKeys: [string, string][] = [
  ['↑ ↓', 'through the lists (in a view: turn it)'],
  ['N', 'next that is open, wrong or suggested'],
  ['F', 'look at the chosen one from near'],
  ['H', 'whole figures again'],
  ['Enter', 'accept a suggestion, rename a pair'],
  ['Backspace', 'refuse a suggestion'],
  ['Del', 'delete a pair'],
  ['Space', 'pick in the middle of the view'],
  ['Esc', 'cancel the pending pick'],
  ['T', 'turn together or apart'],
  ['P', 'plain or textured'],
  ['S', 'suggest'],
  ['M', 'mirror to the other half of the figure'],
  ['Ctrl Enter', 'lay the net on the pose'],
  ['Ctrl Z', 'undo; with Shift: redo'],
]

/** One line: what to do next. */
function hintOf(picking: Picking, surfaces: Surfaces): string {
  const missing = surfaces.template.missing || surfaces.pose.missing
  if (missing) return missing
  const { pending, item, template, pose, said } = picking
  if (said) return said
  if (pending) {
    const other = pending.side === 'template' ? pose : template
    return `${pending.pick.name}: now click the same place on ${other}. Esc cancels.`
  }
  if (item?.kind === 'suggestion')
    return 'The same place on both? Enter accepts, Backspace refuses.'
  if (item && !item.pair.template) return `${item.pair.name}: click its place on ${template}.`
  if (item && !item.pair.pose) return `${item.pair.name}: click its place on ${pose}.`
  if (item) return `Drag ${item.pair.name} to move it; Del deletes it, F2 renames it.`
  return `Click a place on ${template}, then the same place on ${pose}.`
}

export function SaveState({ picking }: { picking: { files: Picking['files'] } }) {
  const { files } = picking
  if (files.failed)
    return (
      <span class="bad">
        Not saved: {files.failed}{' '}
        <button class="quiet" onClick={() => void files.save()}>
          Try again
        </button>
      </span>
    )
  return <span class="soft">{files.saving ? 'Saving…' : 'Saved'}</span>
}

function AdviceList({ advice, picking }: { advice: Advice[]; picking: Picking }) {
  if (advice.length === 0) return null
  return (
    <section class="lm-advice" aria-label="Advice">
      <p class="small">
        One more landmark would help most at{' '}
        {advice.map((_, i) => (
          <button
            key={i}
            class="quiet"
            aria-label={`Look at place ${i + 1}`}
            onClick={() => picking.lookAtAdvice(i)}
          >
            {kAdviceSigns[i]}
          </button>
        ))}{' '}
        on {picking.template}.
      </p>
    </section>
  )
}

/** Picks where the crosshair of the view with the focus is. */
function pickInMiddle(event: KeyboardEvent, surfaces: Surfaces, picking: Picking): void {
  const canvas = event.target as Element
  for (const side of kSides) {
    const { viewer, data } = surfaces[side]
    const hit = viewer?.element === canvas && data ? hitInMiddle(viewer, canvas) : null
    if (hit) picking.pick(side, hit)
  }
}

interface Looks {
  plain: boolean
  together: boolean
  setPlain: (plain: boolean) => void
  setTogether: (together: boolean) => void
}

function usePickKeys(
  surfaces: Surfaces,
  picking: Picking,
  looks: Looks,
  press: (action: string) => void,
): void {
  const { item } = picking
  const suggested = item?.kind === 'suggestion'
  const rename = () => item?.kind === 'pair' && picking.setRenaming(item.pair.name)
  const refuse = () => (suggested ? picking.decide(false) : picking.remove())
  useKeys({
    ArrowUp: () => picking.step(-1),
    ArrowDown: () => picking.step(1),
    n: picking.next,
    f: picking.focus,
    h: () => kSides.forEach((side) => surfaces[side].viewer?.setTurn(wholeView())),
    Enter: () => (suggested ? picking.decide(true) : rename()),
    F2: rename,
    Backspace: refuse,
    Delete: refuse,
    Escape: picking.cancel,
    ' ': (event) => pickInMiddle(event, surfaces, picking),
    t: () => looks.setTogether(!looks.together),
    p: () => looks.setPlain(!looks.plain),
    s: () => press('suggest'),
    m: () => press('mirror'),
    'ctrl+Enter': () => press('register'),
    'ctrl+z': picking.undo,
    'ctrl+shift+z': picking.redo,
    'ctrl+y': picking.redo,
  })
}

/** The name that the next pair gets, and the search for suggestions. */
function NextPair(props: { picking: Picking; surfaces: Surfaces; mirrors: boolean }) {
  const { picking, surfaces } = props
  return (
    <div class="row lm-name-row">
      <label class="lm-next">
        <span class="hidden">Name of the next pair</span>
        <input
          value={picking.typed}
          placeholder={`next: ${picking.auto}`}
          maxLength={64}
          onInput={(event) => picking.setTyped(event.currentTarget.value)}
          onKeyDown={(event) => event.key === 'Enter' && event.currentTarget.blur()}
        />
      </label>
      <button
        data-action="suggest"
        disabled={picking.searching || !surfaces.template.data || !surfaces.pose.data}
        title="Looks for places that are the same on both (S)"
        onClick={() => void picking.suggest()}
      >
        {picking.searching ? 'Looking…' : 'Suggest'}
      </button>
      {props.mirrors && (
        <button
          data-action="mirror"
          disabled={picking.searching || !surfaces.template.data || !surfaces.pose.data}
          title="Puts the landmarks of one half of a symmetric figure on its other half (M)"
          onClick={() => void picking.mirror()}
        >
          Mirror
        </button>
      )}
    </div>
  )
}

export function PoseChoice(props: { pose: string; poses: Pose[]; onPose: (name: string) => void }) {
  return (
    <select
      aria-label="Pose"
      class="lm-pose"
      value={props.pose}
      onChange={(event) => props.onPose(event.currentTarget.value)}
    >
      {props.poses.map((pose) => (
        <option key={pose.name} value={pose.name}>
          {pose.name}
        </option>
      ))}
    </select>
  )
}

/** What to do next, whether all is saved, and how the views look. */
function Foot(props: { picking: Picking; surfaces: Surfaces; looks: Looks }) {
  const { picking, surfaces, looks } = props
  return (
    <div class="lm-foot">
      <span role="status" class="lm-hint">
        {hintOf(picking, surfaces)}
      </span>
      <span class="lm-gap" />
      <span class="small">
        <SaveState picking={picking} />
      </span>
      <LookChoice plain={looks.plain} change={looks.setPlain} />
      <button
        aria-pressed={looks.together}
        title="Both views turn at once (T)"
        onClick={() => looks.setTogether(!looks.together)}
      >
        Turn together
      </button>
      <KeysHelp keys={kKeys} />
    </div>
  )
}

const kSuggestions = 12

export function PickBench(props: {
  template: Pose
  pose: Pose
  poses: Pose[]
  onPose: (name: string) => void
  modes: ComponentChildren
}) {
  const { steps } = useStudio()
  const { template, pose } = props
  const looks = useLooks()
  const surfaces: Surfaces = {
    template: useSurface(template, steps, looks.plain),
    pose: useSurface(pose, steps, looks.plain),
  }
  const advice = useAdvice(pose.name)
  const files = usePickFiles()
  const picking = usePicking(files, surfaces, advice, () => api.suggest(pose.name, kSuggestions))
  const take = useImport(files)
  const stage = (side: Side) => {
    const { name } = surfaces[side]
    const label = `Drop a file of landmarks of ${name}`
    return (
      <DropPlace label={label} take={(file) => void take(name, file)}>
        <SurfaceStage surface={surfaces[side]} label={`${name}: 3D view`} />
      </DropPlace>
    )
  }
  const menu = (side: Side) => {
    const { name } = surfaces[side]
    const empty = picksOf(files.history.now, name).length === 0
    return <FilesMenu pose={name} empty={empty} take={(file) => void take(name, file)} />
  }
  return (
    <PairBench
      title="Landmarks"
      {...{ surfaces, picking, advice, looks }}
      mirrors
      top={props.modes}
      card={(pairs) => <FitCard pose={pose.name} pairs={pairs} save={() => files.save()} />}
    >
      <div class="lm-head">
        <h2>{template.name}</h2>
        <span class="small soft">gives the net</span>
        <span class="lm-gap" />
        {menu('template')}
      </div>
      <div class="lm-head">
        <PoseChoice pose={pose.name} poses={props.poses} onPose={props.onPose} />
        <span class="small soft">pose</span>
        <span class="lm-gap" />
        {menu('pose')}
      </div>
      {stage('template')}
      {stage('pose')}
    </PairBench>
  )
}

export function useLooks(): Looks {
  const [plain, setPlain] = useState(false)
  const [together, setTogether] = useState(true)
  return { plain, together, setPlain, setTogether }
}

/** Two views with pairs of places, their lists, and the keys. */
export function PairBench(props: {
  title: string
  surfaces: Surfaces
  picking: Picking
  advice: Advice[]
  looks: Looks
  /** whether picks of one half can be put on the other */
  mirrors?: boolean
  /** above the lists */
  top: ComponentChildren
  /** below them, told how many pairs are whole */
  card: (pairs: number) => ComponentChildren
  /** heads and views of both sides */
  children: ComponentChildren
}) {
  const { surfaces, picking, advice, looks } = props
  const main = useRef<HTMLElement>(null)
  // For the test that a pick is fast; nobody reads it on the page.
  const onHit = (hit: Hit) => (main.current!.dataset.pickMs = hit.ms.toFixed(3))
  useLinkedTurns(surfaces, looks.together)
  useMarkers('template', surfaces.template, picking, advice, onHit)
  useMarkers('pose', surfaces.pose, picking, advice, onHit)
  usePickKeys(surfaces, picking, looks, (action) =>
    main.current?.querySelector<HTMLButtonElement>(`[data-action="${action}"]`)?.click(),
  )
  const pairs = picking.items.filter(
    (item) => item.kind === 'pair' && item.pair.template && item.pair.pose,
  )
  return (
    <main class="page lm" ref={main} data-pick-ms="">
      <h1 class="hidden">{props.title}</h1>
      <div class="side lm-side">
        {props.top}
        <NextPair picking={picking} surfaces={surfaces} mirrors={props.mirrors ?? false} />
        {picking.whyNone && (
          <p class="warn small lm-none" role="alert">
            {sentence(picking.whyNone)}
          </p>
        )}
        <div class="lm-lists">
          <SuggestionList picking={picking} />
          <PairList picking={picking} />
        </div>
        <AdviceList advice={advice} picking={picking} />
        {props.card(pairs.length)}
      </div>
      <div class="lm-work">
        {props.children}
        <Foot picking={picking} surfaces={surfaces} looks={looks} />
      </div>
    </main>
  )
}

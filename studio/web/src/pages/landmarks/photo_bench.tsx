// Mode 'Pick' of a pose from few photographs: the template beside the pose's photographs.
import type { ComponentChildren } from 'preact'
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks'

import type { PhotoFit, Pose } from '../../api'
import { useKeys } from '../../keys'
import { useStudio } from '../../state'
import type { Zoom } from '../../view/frame_view'
import type { Marker } from '../../view/viewer'
import { LookChoice } from './bench_pieces'
import { FilesMenu, useImport } from './files_menu'
import { KeysHelp } from './keys'
import { PoseChoice, SaveState } from './pick_bench'
import { PhotoFitCard, useStepRun } from './photo_fit_card'
import { PhotoPairList } from './photo_list'
import { colorOf } from './photo_model'
import type { WorstPlace } from './photo_model'
import { usePhotoFit, usePhotoPicking } from './photo_picking'
import type { PhotoPicking } from './photo_picking'
import { PhotoSide } from './photo_side'
import { facing } from './linked_turn'
import { picksOf } from './pick_history'
import { hitInMiddle, normalOf, SurfaceStage, useSurface, wholeView } from './surface'
import type { Surface } from './surface'

const kKeys: [string, string][] = [
  ['↑ ↓', 'through the list (in the 3D view: turn it)'],
  [', .', 'previous, next photograph'],
  ['O', 'outline of the mask'],
  ['P', 'plain or textured'],
  ['H', 'whole figure, whole photograph'],
  ['F2', 'rename a pair'],
  ['Del', 'delete a pair'],
  ['Space', 'pick in the middle of the view'],
  ['Esc', 'nothing chosen: the next click begins a pair'],
  ['Ctrl Enter', 'fit'],
  ['Ctrl Z', 'undo; with Shift: redo'],
]

/** How near the view of the template comes, in sizes of the figure. */
const kNearPhotograph = 5

/** One line: what to do next. */
function hintOf(picking: PhotoPicking, surface: Surface, image: string): string {
  if (surface.missing) return surface.missing
  const { pending, pair, template, said } = picking
  if (said) return said
  if (pending?.place)
    return `${pending.name}: now click the same place in a photograph. Esc cancels.`
  if (pending) return `${pending.name}: now click the same place on ${template}. Esc cancels.`
  if (pair && !pair.template) return `${pair.name}: click its place on ${template}.`
  if (pair && !pair.pixels.some((one) => one.image === image))
    return `${pair.name}: click it here if this photograph shows it. Esc for a new pair.`
  if (pair?.pixels.length === 1)
    return `One photograph says in which direction ${pair.name} lies; pick it in a second one, too.`
  if (pair) return `Drag ${pair.name} to move it; Del deletes it, F2 renames it.`
  return `Click a place on ${template}, then the same place in a photograph.`
}

/** Shows the template's picks, and passes on what is done to them. */
function useTemplateMarkers(surface: Surface, picking: PhotoPicking): void {
  const { viewer, data } = surface
  const { pairs, pending, chosen } = picking
  const show = () => {
    if (!viewer || !data) return
    const markers = pairs.flatMap((pair, index): Marker[] => {
      if (!pair.template || pair.template.face >= data.faces) return []
      const { face, barycentric } = pair.template
      const place = viewer.placeOf(face, barycentric)
      if (pair.name === chosen) return [{ name: pair.name, place, kind: 'chosen' }]
      return [{ name: pair.name, place, kind: 'landmark', color: colorOf(index) }]
    })
    if (pending?.place) {
      const place = viewer.placeOf(pending.place.face, pending.place.barycentric)
      markers.push({ name: `${pending.name} …`, place, kind: 'chosen' })
    }
    viewer.setMarkers(markers)
  }
  useEffect(show, [viewer, data, JSON.stringify([pairs, pending, chosen])])
  // At once, not after the next frame: a click must not meet what was true before the last one.
  useLayoutEffect(() => {
    if (!viewer) return
    const nameOf = (label: string) => label.replace(/ …$/, '')
    viewer.onPick = (hit) => hit && data && picking.pickPlace(hit)
    viewer.onMarker = (label) => {
      if (!label.endsWith(' …')) picking.choose(label)
      show() // a hand that trembled has moved the marker
    }
    viewer.onMarkerDrag = (label, hit, done) => {
      viewer.moveMarker(label, hit.place)
      if (done) picking.movePlace(nameOf(label), hit)
    }
  })
  // The chosen one is turned to, if it is behind the figure.
  useEffect(() => {
    const pick = pairs.find((pair) => pair.name === chosen)?.template
    if (!viewer || !data || !pick || pick.face >= data.faces) return
    if (viewer.isHidden(viewer.placeOf(pick.face, pick.barycentric)))
      viewer.setTurn({ ...viewer.turn(), direction: facing(normalOf(data, pick.face)) })
  }, [chosen, viewer, data])
}

/** Before capture has read the photographs. */
function NoPhotographs({ pose, fit }: { pose: string; fit: PhotoFit | null }) {
  const { run, atWork, step } = useStepRun(`capture/${pose}`, async () => undefined)
  return (
    <div class="ph-side">
      <div class="view">
        <div class="lm-wait" role="status">
          {fit === null ? (
            'Loading…'
          ) : (
            <div class="stack">
              <span>The photographs of {pose} have not been read yet.</span>
              {step?.state === 'failed' && <span class="small bad">{step.error}</span>}
              <button class="main" disabled={atWork} onClick={() => void run()}>
                {atWork ? 'Reading…' : 'Read them'}
              </button>
            </div>
          )}
        </div>
      </div>
    </div>
  )
}

function Foot(props: {
  hint: string
  picking: PhotoPicking
  plain: boolean
  setPlain: (plain: boolean) => void
  outline: boolean
  setOutline: (outline: boolean) => void
}) {
  return (
    <div class="lm-foot">
      <span role="status" class="lm-hint">
        {props.hint}
      </span>
      <span class="lm-gap" />
      <span class="small">
        <SaveState picking={props.picking} />
      </span>
      <LookChoice plain={props.plain} change={props.setPlain} />
      <button
        aria-pressed={props.outline}
        title="The outline of the mask (O)"
        onClick={() => props.setOutline(!props.outline)}
      >
        Outline
      </button>
      <KeysHelp keys={kKeys} />
    </div>
  )
}

/** The name that the next pair gets. */
function NextName({ picking }: { picking: PhotoPicking }) {
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
    </div>
  )
}

export function PhotoBench(props: {
  template: Pose
  pose: Pose
  poses: Pose[]
  onPose: (name: string) => void
  modes: ComponentChildren
}) {
  const { steps } = useStudio()
  const pose = props.pose.name
  const [plain, setPlain] = useState(false)
  const [outline, setOutline] = useState(true)
  const [wanted, setWanted] = useState('')
  const [look, setLook] = useState<Zoom | null>(null)
  const surface = useSurface(props.template, steps, plain)
  const main = useRef<HTMLElement>(null)
  const [names, setNames] = useState<string[]>([])
  const image = names.includes(wanted) ? wanted : (names[0] ?? '')
  const picking = usePhotoPicking(props.template.name, pose, image)
  const fit = usePhotoFit(pose, picking.files)
  const listed = fit?.photographs.map((one) => one.name).join('\n') ?? ''
  useLayoutEffect(() => setNames(listed === '' ? [] : listed.split('\n')), [listed])
  const take = useImport(picking.files)
  useTemplateMarkers(surface, picking)

  const show = (name: string) => {
    setLook(null)
    setWanted(name)
  }
  const lookAtPlace = (place: WorstPlace) => {
    setWanted(place.image)
    const [x, y] = place.pixel
    // After the photograph has changed, which shows the whole of it.
    setTimeout(() => setLook({ scale: kNearPhotograph, x, y }))
  }
  const photograph = fit?.photographs.find((one) => one.name === image)
  const nextPhotograph = (by: number) => {
    const at = names.indexOf(image) + by
    if (at >= 0 && at < names.length) show(names[at])
  }
  const whole = () => {
    surface.viewer?.setTurn(wholeView())
    if (photograph) setLook({ scale: 1, x: photograph.width / 2, y: photograph.height / 2 })
  }
  const pickInMiddle = (event: KeyboardEvent) => {
    const { viewer, data } = surface
    if (!viewer || !data || event.target !== viewer.element) return
    const hit = hitInMiddle(viewer, viewer.element)
    if (hit) picking.pickPlace(hit)
  }
  useKeys({
    ArrowUp: () => picking.step(-1),
    ArrowDown: () => picking.step(1),
    ',': () => nextPhotograph(-1),
    '.': () => nextPhotograph(1),
    o: () => setOutline(!outline),
    p: () => setPlain(!plain),
    h: whole,
    F2: () => picking.chosen && picking.setRenaming(picking.chosen),
    Enter: () => picking.chosen && picking.setRenaming(picking.chosen),
    Delete: () => picking.remove(),
    Backspace: () => picking.remove(),
    Escape: picking.cancel,
    ' ': pickInMiddle,
    'ctrl+Enter': () =>
      main.current?.querySelector<HTMLButtonElement>('[data-action="fit"]')?.click(),
    'ctrl+z': picking.undo,
    'ctrl+shift+z': picking.redo,
    'ctrl+y': picking.redo,
  })
  const name = props.template.name
  return (
    <main class="page lm photos" ref={main}>
      <h1 class="hidden">Landmarks in photographs</h1>
      <div class="side lm-side">
        {props.modes}
        <NextName picking={picking} />
        <div class="lm-lists">
          <PhotoPairList picking={picking} fit={fit} image={image} show={show} />
        </div>
        <PhotoFitCard
          pose={pose}
          fit={fit}
          save={() => picking.files.save()}
          look={lookAtPlace}
        />
      </div>
      <div class="lm-work">
        <div class="lm-head">
          <h2>{name}</h2>
          <span class="small soft">gives the net</span>
          <span class="lm-gap" />
          <FilesMenu
            pose={name}
            empty={picksOf(picking.files.history.now, name).length === 0}
            take={(file) => void take(name, file)}
          />
        </div>
        <div class="lm-head">
          <PoseChoice pose={pose} poses={props.poses} onPose={props.onPose} />
          <span class="small soft">from few photographs</span>
        </div>
        <div class="lm-drop">
          <SurfaceStage surface={surface} label={`${name}: 3D view`} />
        </div>
        {photograph && fit ? (
          <PhotoSide
            picking={picking}
            fit={fit}
            photograph={photograph}
            show={show}
            outline={outline}
            look={look}
          />
        ) : (
          <NoPhotographs pose={pose} fit={fit} />
        )}
        <Foot
          hint={hintOf(picking, surface, image)}
          picking={picking}
          plain={plain}
          setPlain={setPlain}
          outline={outline}
          setOutline={setOutline}
        />
      </div>
    </main>
  )
}

// Mode 'Paint': stiffness and named regions, with a brush on the template.
import type { ComponentChildren } from 'preact'
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from 'preact/hooks'

import type { Pose } from '../../api'
import { useStudio } from '../../state'
import { useBrushRing } from '../../view/brush_ring'
import { kScaleGradient } from '../../view/colors'
import type { MeshData } from '../../view/mesh_data'
import type { Hit, Viewer } from '../../view/viewer'
import { cssShare, percent } from '../../words'
import { useKeys } from '../../keys'
import { KeysHelp } from './keys'
import { usePaintFiles } from './paint_files'
import type { PaintFiles } from './paint_files'
import { connected, kFactors, kStiffness, levelOf, neighboursOf, regionLayer } from './painting'
import type { Painting } from './painting'
import { UndoButtons } from './pair_list'
import { hitInMiddle, SurfaceStage, useSurface, wholeView } from './surface'

const kSmallest = 0.01
const kLargest = 0.2
/** Colours of regions on the scale: the chosen one, the others, and the rest grey. */
const kChosenLevel = 0.7
const kOtherLevel = 0.3
/** Where nothing is painted: as the plain look. */
const kClay = '#c9bfae'

const kKeys: [string, string][] = [
  ['1 2 3 4', 'soft, normal, stiff, rigid'],
  ['[ ]', 'smaller, larger brush'],
  ['X', 'add or erase'],
  ['↑ ↓', 'stiffness and the regions'],
  ['Space', 'a dab in the middle of the view'],
  ['Alt drag', 'turn, also on the figure'],
  ['H', 'whole figure again'],
  ['Ctrl Z', 'undo; with Shift: redo'],
]

/** What the surface shows: a level of the colour scale by vertex. */
function levelsOf(painting: Painting, target: string, regions: string[], vertices: number) {
  if (target === kStiffness)
    return painting.layer(kStiffness).map((factor) => (factor === 1 ? NaN : levelOf(factor)))
  const levels = new Float32Array(vertices).fill(NaN)
  for (const name of [...regions.filter((one) => regionLayer(one) !== target), null]) {
    const layer = name === null ? target : regionLayer(name)
    const values = painting.layer(layer)
    const level = name === null ? kChosenLevel : kOtherLevel
    for (let v = 0; v < vertices; ++v) if (values[v] > 0) levels[v] = level
  }
  return levels
}

/** Shows the values at most once a frame, however many strokes come. */
function useValues(viewer: Viewer | null, data: MeshData | null, levels: () => Float32Array) {
  const wanted = useRef(false)
  const latest = useRef(levels)
  latest.current = levels
  return () => {
    if (wanted.current || !viewer || !data) return
    wanted.current = true
    requestAnimationFrame(() => {
      wanted.current = false
      viewer.showValues(latest.current(), kClay)
    })
  }
}

function NewRegion(props: { taken: string[]; add: (name: string) => void }) {
  const { complain } = useStudio()
  const [name, setName] = useState('')
  const add = (event: Event) => {
    event.preventDefault()
    const wanted = name.trim()
    if (wanted === '') return
    if (props.taken.includes(wanted)) return complain(`A region is already called '${wanted}'.`)
    props.add(wanted)
    setName('')
  }
  return (
    <form class="row lm-name-row" onSubmit={add}>
      <label class="lm-next">
        <span class="hidden">Name of a new region</span>
        <input
          value={name}
          maxLength={64}
          placeholder="new region: left hand"
          onInput={(event) => setName(event.currentTarget.value)}
        />
      </label>
      <button disabled={name.trim() === ''}>Add</button>
    </form>
  )
}

/** Asks once more in place, as a region cannot be brought back by undo. */
function DeleteRegion({ name, remove }: { name: string; remove: () => void }) {
  const [asked, setAsked] = useState(false)
  return (
    <button
      class={asked ? 'quiet bad' : 'quiet'}
      aria-label={asked ? `Really delete ${name}` : `Delete ${name}`}
      title={asked ? 'Click again to delete it' : 'Delete'}
      onBlur={() => setAsked(false)}
      onClick={() => (asked ? remove() : setAsked(true))}
    >
      {asked ? 'Delete' : '×'}
    </button>
  )
}

function Targets(props: {
  paint: PaintFiles
  target: string
  vertices: number
  onTarget: (layer: string) => void
}) {
  const { paint, target, onTarget } = props
  const { files } = paint
  const share = (layer: string) => {
    const rest = layer === kStiffness ? 1 : 0
    const painted = files.painting.layer(layer).filter((value) => value !== rest).length
    return painted === 0 ? 'nothing painted' : percent(painted / Math.max(1, props.vertices), 1)
  }
  const add = (name: string) => {
    paint.addRegion(name)
    onTarget(regionLayer(name))
  }
  return (
    <div class="lm-lists">
      <section class="lm-pairs" aria-label="What to paint">
        <h2 class="lm-title">Paint</h2>
        <ul class="lm-rows">
          <li class={target === kStiffness ? 'chosen' : ''}>
            <button
              class="lm-row"
              aria-current={target === kStiffness ? 'true' : undefined}
              onClick={() => onTarget(kStiffness)}
            >
              <span class="lm-name">Stiffness</span>
              <span class="lm-state number">{share(kStiffness)}</span>
            </button>
          </li>
        </ul>
        <h2 class="lm-title">Regions · {files.regions.length}</h2>
        {files.regions.length === 0 && (
          <p class="small soft">
            None yet: name one, then paint it. The timeline pins and turns parts by region.
          </p>
        )}
        <ul class="lm-rows">
          {files.regions.map((name) => {
            const layer = regionLayer(name)
            return (
              <li key={name} class={target === layer ? 'chosen' : ''}>
                <button
                  class="lm-row"
                  aria-current={target === layer ? 'true' : undefined}
                  onClick={() => onTarget(layer)}
                >
                  <span class="lm-name">{name}</span>
                  <span class="lm-state number">{share(layer)}</span>
                </button>
                <span class="lm-tools">
                  <DeleteRegion
                    name={name}
                    remove={() => {
                      onTarget(kStiffness)
                      paint.removeRegion(name)
                    }}
                  />
                </span>
              </li>
            )
          })}
        </ul>
        <NewRegion taken={files.regions} add={add} />
      </section>
    </div>
  )
}

function StiffnessLegend() {
  return (
    <div class="lm-scale" aria-hidden="true">
      <div style={{ background: kScaleGradient }} />
      <i style={{ left: cssShare(levelOf(1)), background: kClay }} />
      {kFactors.map((one) => (
        <span key={one.name} style={{ left: cssShare(levelOf(one.factor)) }}>
          {one.name}
        </span>
      ))}
    </div>
  )
}

export function PaintBench(props: { template: Pose; modes: ComponentChildren }) {
  const { steps } = useStudio()
  const surface = useSurface(props.template, steps, true)
  const { viewer, data } = surface
  const [target, setTarget] = useState(kStiffness)
  const [factor, setFactor] = useState(8)
  const [erase, setErase] = useState(false)
  const [radius, setRadius] = useState(0.05)
  const refresh = useRef(() => {})
  const paint = usePaintFiles(data, () => refresh.current())
  const { painting, regions } = paint.files
  const vertices = data?.vertices ?? 0
  refresh.current = useValues(viewer, data, () => levelsOf(painting, target, regions, vertices))
  useEffect(() => refresh.current(), [viewer, data, target, painting, regions.length])
  const neighbours = useMemo(() => data && neighboursOf(data.indices, data.vertices), [data])
  const ring = useBrushRing(viewer, radius)
  const main = useRef<HTMLElement>(null)

  const onStiffness = target === kStiffness
  const value = onStiffness ? (erase ? 1 : factor) : erase ? 0 : 1
  const dab = (hit: Hit) => {
    if (!viewer || !data || !neighbours) return
    main.current!.dataset.pickMs = hit.ms.toFixed(3)
    const near = viewer.verticesNear(hit.place, radius).map((one) => one.vertex)
    const corners = [0, 1, 2].map((k) => data.indices[3 * hit.face + k])
    // The face under the pointer counts also where a brush is smaller than a face.
    painting.paint(connected([...near, ...corners], corners, neighbours), value)
    refresh.current()
  }
  const end = () => {
    if (painting.end()) paint.changed(target)
  }
  useLayoutEffect(() => {
    if (!viewer) return
    viewer.onBrush = (hit, phase) => {
      if (!paint.files.loaded) return
      if (phase === 'begin') painting.begin(target)
      dab(hit)
      if (phase === 'end') end()
    }
    return () => {
      viewer.onBrush = null
    }
  })
  const travel = (layer: string) => {
    if (layer === '') return
    paint.changed(layer)
    setTarget(layer)
    refresh.current()
  }
  const dabInMiddle = (event: KeyboardEvent) => {
    if (!viewer?.element.contains(event.target as Node)) return
    const hit = hitInMiddle(viewer, viewer.element)
    if (!hit) return
    painting.begin(target)
    dab(hit)
    end()
  }
  const resize = (by: number) =>
    setRadius((old) => Math.min(kLargest, Math.max(kSmallest, old * by)))
  const step = (by: number) => {
    const layers = [kStiffness, ...regions.map(regionLayer)]
    const at = layers.indexOf(target) + by
    setTarget(layers[Math.min(layers.length - 1, Math.max(0, at))])
  }
  const factorKeys = Object.fromEntries(
    kFactors.map((one) => [one.key, () => (setFactor(one.factor), setErase(false))]),
  )
  useKeys({
    ...factorKeys,
    '[': () => resize(1 / 1.25),
    ']': () => resize(1.25),
    x: () => setErase((old) => !old),
    ArrowUp: () => step(-1),
    ArrowDown: () => step(1),
    ' ': dabInMiddle,
    h: () => viewer?.setTurn(wholeView()),
    'ctrl+z': () => travel(painting.undo()),
    'ctrl+shift+z': () => travel(painting.redo()),
    'ctrl+y': () => travel(painting.redo()),
  })

  const { saving, failed } = paint.files
  const what = onStiffness ? 'stiffness' : `region ${target.slice(regionLayer('').length)}`
  return (
    <main class="page lm" ref={main} data-pick-ms="">
      <h1 class="hidden">Landmarks: paint</h1>
      <div class="side lm-side">
        {props.modes}
        <Targets paint={paint} target={target} vertices={vertices} onTarget={setTarget} />
        <section class="lm-brush" aria-label="Brush">
          <div class="row spread">
            <h2 class="lm-title">Brush</h2>
            <UndoButtons
              undo={() => travel(painting.undo())}
              redo={() => travel(painting.redo())}
              canUndo={painting.canUndo}
              canRedo={painting.canRedo}
            />
          </div>
          <div class="choice lm-wide" role="group" aria-label="What the brush does">
            <button aria-pressed={!erase} title="Add (X)" onClick={() => setErase(false)}>
              {onStiffness ? 'Paint' : 'Add'}
            </button>
            <button aria-pressed={erase} title="Erase (X)" onClick={() => setErase(true)}>
              Erase
            </button>
          </div>
          {onStiffness && (
            <div class="choice lm-wide" role="group" aria-label="Stiffness to paint">
              {kFactors.map((one) => (
                <button
                  key={one.name}
                  aria-pressed={!erase && factor === one.factor}
                  title={`${one.about} (${one.key})`}
                  onClick={() => (setFactor(one.factor), setErase(false))}
                >
                  {one.name}
                </button>
              ))}
            </div>
          )}
          <label class="lm-slider">
            Radius
            <input
              type="range"
              min={kSmallest}
              max={kLargest}
              step={0.005}
              value={radius}
              aria-valuetext={`${percent(radius)} of the figure`}
              onInput={(event) => setRadius(Number(event.currentTarget.value))}
            />
            <span class="number">{percent(radius)}</span>
          </label>
        </section>
      </div>
      <div class="lm-work one">
        <div class="lm-head">
          <h2>{props.template.name}</h2>
          <span class="small soft">template, {what}</span>
        </div>
        <SurfaceStage surface={surface} label={`${props.template.name}: 3D view to paint on`}>
          <div class="brush-ring" ref={ring} aria-hidden="true" />
          {onStiffness && data && <StiffnessLegend />}
        </SurfaceStage>
        <div class="lm-foot">
          <span role="status" class="lm-hint">
            Drag on the figure to {erase ? 'erase' : 'paint'} {what}; drag beside it to turn.
          </span>
          <span class="lm-gap" />
          <span class="small">
            {failed ? (
              <span class="bad">
                Not saved: {failed}{' '}
                <button class="quiet" onClick={paint.retry}>
                  Try again
                </button>
              </span>
            ) : (
              <span class="soft">{saving ? 'Saving…' : 'Saved'}</span>
            )}
          </span>
          <KeysHelp keys={kKeys} />
        </div>
      </div>
    </main>
  )
}

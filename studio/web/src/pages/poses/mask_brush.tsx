// Mends the mask of one photograph with a brush.
import { useCallback, useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Pose } from '../../api'
import { useStudio } from '../../state'
import { percent } from '../../words'
import { BrushHistory, BrushKeys, BrushTools, Measures, stepSize, WholeMask } from './brush_side'
import { BrushSurface } from './brush_surface'
import type { Tool } from './brush_surface'
import { inField } from './keys'
import { useLoaded } from './load'
import type { MaskCanvas } from './mask_canvas'
import { MaskModel } from './mask_model'
import { OlderMasks } from './older_masks'
import { loadMask, loadPhotograph } from './mask_picture'
import { greyPng } from './png'
import type { Judged } from './quality'
import { useLeaveGuard } from './route'
import { Strip } from './strip'

interface Sheet {
  pose: Pose
  judged: Judged[]
  name: string
  open: (name: string) => void
  close: () => void
}

interface Painting {
  picture: ImageBitmap
  model: MaskModel
  /** of the mask that the strokes are on; '': there was none */
  revision: string
  /** SHA-256 of the photograph under the strokes */
  photograph: string
}

async function load(pose: string, { photograph }: Judged): Promise<Painting> {
  const picture = await loadPhotograph(pose, photograph.name, photograph.photograph)
  // Before capture nobody has measured the photograph but the browser.
  const width = photograph.width || picture.width
  const height = photograph.height || picture.height
  const mask = await loadMask(pose, photograph.name, width, height)
  const model = new MaskModel(width, height, mask?.values)
  return { picture, model, revision: mask?.revision ?? '', photograph: photograph.photograph }
}

/** The tool stays from photograph to photograph; the rest begins anew with each. */
export function MaskBrush(sheet: Sheet) {
  const [tool, setTool] = useState<Tool>({
    mode: 'add',
    shape: 'brush',
    size: 40,
    look: 'tint',
  })
  const judged = sheet.judged.find((one) => one.photograph.name === sheet.name)
  if (!judged)
    return (
      <main class="empty">
        <h1>No photograph of this name</h1>
        <button onClick={sheet.close}>Back to the photographs</button>
      </main>
    )
  return <Brush key={sheet.name} {...sheet} one={judged} tool={tool} setTool={setTool} />
}

function Brush(props: Sheet & { one: Judged; tool: Tool; setTool: (tool: Tool) => void }) {
  const { pose, one, name, tool, setTool } = props
  const { tell, complain } = useStudio()
  const [decisions, setDecisions] = useState(0)
  const [shot, setShot] = useState(one.photograph.photograph)
  const painting = useLoaded(() => load(pose.name, one), [pose.name, name, decisions, shot])
  const model = painting.value?.model ?? null
  // One that is shot again is shown at once, unless that would take strokes away.
  useEffect(() => {
    if (!model?.changed) setShot(one.photograph.photograph)
  }, [one.photograph.photograph])
  const canvas = useRef<MaskCanvas | null>(null)
  const [zoom, setZoom] = useState(1)
  const [, setStrokes] = useState(0)
  const stroked = useCallback(() => setStrokes((old) => old + 1), [])
  const guard = useLeaveGuard(model?.changed ?? false)
  const saving = useSaving(pose, name, painting.value, stroked)

  const ready = useCallback((made: MaskCanvas | null) => {
    canvas.current = made
    if (made) made.onView = () => setZoom(made.zoom())
  }, [])
  const undo = () => {
    canvas.current?.maskChanged(model?.undo() ?? null)
    stroked()
  }
  const redo = () => {
    canvas.current?.maskChanged(model?.redo() ?? null)
    stroked()
  }
  const beside = (step: number) => {
    const names = props.judged.map((other) => other.photograph.name)
    return names[names.indexOf(name) + step] ?? ''
  }
  const neighbour = (step: number) => {
    const next = beside(step)
    if (next) props.open(next)
  }
  const become = (values: (i: number) => number) => {
    canvas.current?.maskChanged(model?.become(values) ?? null)
    stroked()
  }
  const invert = () => model && become((i) => 255 - model.values[i])
  const take = async (from: string) => {
    if (!model) return
    try {
      const other = await loadMask(pose.name, from, model.width, model.height)
      if (other) become((i) => other.values[i])
      else tell(`${from} has no mask yet.`)
    } catch (error) {
      complain(error)
    }
  }
  useBrushKeys({
    undo,
    redo,
    invert,
    save: () => void saving.save(false),
    tool: setTool,
    current: tool,
    canvas,
    neighbour,
    close: props.close,
    held: guard.wanted !== '',
  })
  return (
    <main class="page poses brush">
      <aside class="side" aria-label="Mask brush">
        <div class="stack head">
          <button class="quiet back" onClick={props.close}>
            ‹ Photographs of {pose.name}
          </button>
          <div class="row spread">
            <h1 class="name">{name}</h1>
            {one.photograph.mask_given && <span class="tag soft">own mask</span>}
          </div>
          <Measures judged={one} />
          <OlderMasks
            pose={pose.name}
            names={one.photograph.mask_of_another ? [name] : []}
            disabled={model?.changed}
            decided={() => setDecisions((old) => old + 1)}
          />
        </div>
        <BrushTools tool={tool} change={setTool} />
        <WholeMask invert={invert} before={beside(-1)} after={beside(1)} take={(from) => void take(from)} />
        <BrushHistory
          canUndo={model?.canUndo ?? false}
          canRedo={model?.canRedo ?? false}
          undo={undo}
          redo={redo}
        />
        <div class="row spread zoom" role="group" aria-label="View">
          <button onClick={() => canvas.current?.fit()}>Fit</button>
          <button onClick={() => canvas.current?.zoomTo(1)}>100 %</button>
          <output class="number small soft" aria-label="Zoom">
            {percent(zoom)}
          </output>
        </div>
        <BrushKeys />
        <SaveButtons saving={saving} changed={model?.changed ?? false} shape={tool.shape} />
      </aside>
      <div class="easel">
        {painting.error && <p class="empty">{painting.error}</p>}
        {model && painting.value && (
          <BrushSurface
            model={model}
            picture={painting.value.picture}
            tool={tool}
            label={`${name} with its mask. Arrow keys move the tool, Enter uses it.`}
            ready={ready}
            stroked={stroked}
          />
        )}
        {!model && !painting.error && <p class="empty">Opens {name} …</p>}
        <Strip
          src={(one) => api.photoUrl(pose.name, one, 320)}
          label="Photographs of this pose"
          names={props.judged.map((other) => other.photograph.name)}
          current={name}
          choose={props.open}
        />
      </div>
      {guard.wanted && (
        <LeaveDialog
          name={name}
          stay={guard.stay}
          discard={guard.leave}
          save={async () => ((await saving.save(false)) ? guard.leave() : guard.stay())}
        />
      )}
    </main>
  )
}

interface Saving {
  busy: boolean
  /** why a run cannot start now, or '' */
  held: string
  save: (rerun: boolean) => Promise<boolean>
}

function useSaving(
  pose: Pose,
  name: string,
  painting: Painting | null,
  saved: () => void,
): Saving {
  const { steps, running, tell, complain, reload } = useStudio()
  const [busy, setBusy] = useState(false)
  const held = running ? 'A run is at work; save, and run when it is done.' : steps.locked_by
  const bake = steps.steps.find((step) => step.stage === 'bake' && step.pose === pose.name)
  const save = async (rerun: boolean) => {
    if (!painting || busy) return false
    const { model } = painting
    setBusy(true)
    try {
      if (model.changed) {
        const mark = model.mark()
        const png = await greyPng(model.width, model.height, model.values)
        const { revision, photograph } = painting
        painting.revision = await api.saveMask(pose.name, name, png, revision, photograph)
        model.markSavedAt(mark)
      }
      if (rerun) await api.run({ until: [bake?.id ?? `bake/${pose.name}`] })
      tell(rerun ? `Saved. ${pose.name} is made anew up to its texture.` : `Saved: ${name}.`)
      await reload()
      return true
    } catch (error) {
      complain(error)
      return false
    } finally {
      setBusy(false)
      saved()
    }
  }
  return { busy, held, save }
}

const kHints: Record<Tool['shape'], string> = {
  brush: 'Paint over what belongs to the figure.',
  lasso: 'Draw a line round it with the button held.',
  fill: 'Click into a hole; or, with Remove, on a speck.',
}

function SaveButtons(props: { saving: Saving; changed: boolean; shape: Tool['shape'] }) {
  const { saving, changed } = props
  return (
    <div class="stack save">
      <p class="small soft" role="status">
        {changed ? 'Strokes not saved yet.' : kHints[props.shape]}
      </p>
      <div class="choice wide">
        <button
          class={changed ? 'main' : ''}
          disabled={!changed || saving.busy || saving.held !== ''}
          title={saving.held || 'Saves, and makes what hangs on this mask again'}
          onClick={() => void saving.save(true)}
        >
          Save and re-run
        </button>
        <button
          disabled={!changed || saving.busy}
          aria-keyshortcuts="Control+S"
          onClick={() => void saving.save(false)}
        >
          Save
        </button>
      </div>
    </div>
  )
}

function LeaveDialog(props: {
  name: string
  stay: () => void
  discard: () => void
  save: () => void
}) {
  const dialog = useRef<HTMLDialogElement>(null)
  useEffect(() => dialog.current!.showModal(), [])
  return (
    <dialog ref={dialog} aria-labelledby="leave-title" onClose={props.stay}>
      <h2 id="leave-title">Strokes on {props.name} are not saved</h2>
      <div class="row">
        <button class="main" onClick={props.save}>
          Save and go
        </button>
        <button onClick={props.discard}>Throw them away</button>
        <button class="quiet" onClick={props.stay}>
          Go on painting
        </button>
      </div>
    </dialog>
  )
}

const kShapeKeys: Record<string, Tool['shape']> = { b: 'brush', l: 'lasso', f: 'fill' }

interface KeyActions {
  undo: () => void
  redo: () => void
  invert: () => void
  save: () => void
  tool: (tool: Tool) => void
  current: Tool
  canvas: { current: MaskCanvas | null }
  neighbour: (step: number) => void
  close: () => void
  /** true: a question is on the screen; keys belong to it */
  held: boolean
}

function useBrushKeys(actions: KeyActions) {
  const latest = useRef(actions)
  latest.current = actions
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      if (latest.current.held || inField(event)) return
      const done = event.ctrlKey || event.metaKey ? control(event) : plain(event)
      if (done) event.preventDefault()
    }
    const control = (event: KeyboardEvent): boolean => {
      const { undo, redo, save } = latest.current
      const wanted = event.key.toLowerCase()
      if (wanted === 'z') event.shiftKey ? redo() : undo()
      else if (wanted === 'y') redo()
      else if (wanted === 's') save()
      else return false
      return true
    }
    const plain = (event: KeyboardEvent): boolean => {
      const { canvas, neighbour, close, invert } = latest.current
      if (event.key === 'Escape') close()
      else if (event.key === 'PageUp') neighbour(-1)
      else if (event.key === 'PageDown') neighbour(1)
      else if (event.key.toLowerCase() === 'i') invert()
      else if (event.key === '0') canvas.current?.fit()
      else if (event.key === '1') canvas.current?.zoomTo(1)
      else if (event.key === '+' || event.key === '=') zoomBy(1.25)
      else if (event.key === '-') zoomBy(0.8)
      else return changeTool(event.key.toLowerCase())
      return true
    }
    const zoomBy = (factor: number) => {
      const canvas = latest.current.canvas.current
      canvas?.zoomTo(canvas.zoom() * factor)
    }
    const changeTool = (wanted: string): boolean => {
      const { current, tool } = latest.current
      const looks: Tool['look'][] = ['tint', 'outline', 'figure']
      if (wanted === 'a') tool({ ...current, mode: 'add' })
      else if (wanted === 'r' || wanted === 'x') tool({ ...current, mode: 'remove' })
      else if (kShapeKeys[wanted]) tool({ ...current, shape: kShapeKeys[wanted] })
      else if (wanted === '[' || wanted === ']')
        tool({ ...current, size: stepSize(current.size, wanted === ']') })
      else if (wanted === 't')
        tool({ ...current, look: looks[(looks.indexOf(current.look) + 1) % looks.length] })
      else return false
      return true
    }
    addEventListener('keydown', key)
    return () => removeEventListener('keydown', key)
  }, [])
}

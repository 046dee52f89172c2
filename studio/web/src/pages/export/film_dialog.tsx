// The film in one dialogue: camera, lens, light, background, size, length; with the figure as the
// film will show it.
import type { JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'

import { api, ApiError } from '../../api'
import type { Step } from '../../api'
import { useStudio } from '../../state'
import { parseMesh } from '../../view/mesh_data'
import { shownFront } from '../../view/front'
import { ViewerStage } from '../../view/stage'
import type { Viewer } from '../../view/viewer'
import { useLoaded, useSize } from '../poses/load'
import { colourOf, filmCamera, fovOf, kBackgrounds, kSizes, lensOf } from './film_camera'

/** Values of the export's options, as text. */
type Values = Record<string, string>
const kNames = [
  'video_azimuth',
  'video_elevation',
  'video_fov',
  'video_light',
  'video_shadow',
  'video_background',
  'video_width',
  'video_height',
  'hold',
  'loop',
]

export function FilmButton({ step }: { step: Step }) {
  const [open, setOpen] = useState(false)
  if (kNames.some((name) => step.options[name] === undefined)) return null
  return (
    <>
      <button onClick={() => setOpen(true)}>Set up the film …</button>
      {open && <FilmDialog step={step} close={() => setOpen(false)} />}
    </>
  )
}

function FilmDialog({ step, close }: { step: Step; close: () => void }) {
  const { reload, complain, tell } = useStudio()
  const dialog = useRef<HTMLDialogElement>(null)
  const before = Object.fromEntries(kNames.map((name) => [name, step.options[name]]))
  const [values, setValues] = useState<Values>(before)
  const [busy, setBusy] = useState(false)
  useEffect(() => dialog.current!.showModal(), [])
  const set = (more: Values) => setValues((old) => ({ ...old, ...more }))
  const save = async () => {
    setBusy(true)
    try {
      for (const name of kNames)
        if (values[name] !== before[name]) {
          const { revision } = await api.project()
          await api.setOption({ step: step.step, pose: '', option: name, value: values[name], revision })
        }
      tell('Press Export: the film is made so.')
      close()
    } catch (error) {
      if (error instanceof ApiError && error.status === 409)
        tell('The project was changed elsewhere; press Save again.')
      else complain(error)
    }
    await reload()
    setBusy(false)
  }
  return (
    <dialog ref={dialog} class="film-dialog" aria-labelledby="film-title" onClose={close}>
      <h2 id="film-title">The film</h2>
      <div class="film-desk">
        <Preview values={values} set={set} />
        <div class="stack">
          <Camera values={values} set={set} />
          <Look values={values} set={set} />
          <Length values={values} set={set} />
        </div>
      </div>
      <div class="row end">
        <button class="quiet" onClick={close}>
          Cancel
        </button>
        <button class="main" disabled={busy} onClick={() => void save()}>
          Save
        </button>
      </div>
    </dialog>
  )
}

interface Editing {
  values: Values
  set: (more: Values) => void
}

/** -1 is the side with most motion, which only the export finds. */
const azimuthOf = (values: Values) => Math.max(0, Number(values.video_azimuth))

function Preview({ values, set }: Editing) {
  const { project } = useStudio()
  const [viewer, setViewer] = useState<Viewer | null>(null)
  const { element: frame, size } = useSize<HTMLDivElement>()
  const pose = project.poses.find((one) => one.template && one.meshes.includes('mesh'))
  const data = useLoaded(
    async () => (pose ? parseMesh(await api.mesh(pose.name, 'mesh')) : null),
    [pose?.name],
  ).value
  const width = Number(values.video_width)
  const height = Number(values.video_height)
  useEffect(() => {
    if (!viewer || !data || !pose) return
    const textured = pose.has_texture && data.uvs
    viewer.show(data, textured ? 'texture' : 'plain')
    if (textured) viewer.loadTexture(api.textureUrl(pose.name)).catch(() => undefined)
  }, [viewer, data])
  useEffect(() => {
    if (!viewer || !data) return
    viewer.lookThrough(
      filmCamera(data.positions, {
        azimuth: azimuthOf(values) + shownFront.degrees,
        elevation: Number(values.video_elevation),
        fov: Number(values.video_fov),
        width,
        height,
        shadow: values.video_shadow === 'true',
      }),
    )
  }, [viewer, data, values, size.width, size.height])
  const drag = (event: PointerEvent) => {
    const host = event.currentTarget as HTMLElement
    if (event.type === 'pointerdown') host.setPointerCapture(event.pointerId)
    else if (host.hasPointerCapture(event.pointerId)) {
      const turned = (azimuthOf(values) - event.movementX / 2 + 720) % 360
      const raised = Number(values.video_elevation) + event.movementY / 3
      set({
        video_azimuth: String(Math.round(turned)),
        video_elevation: String(Math.round(Math.min(80, Math.max(0, raised)))),
      })
    }
  }
  return (
    <div
      class="film-frame"
      ref={frame}
      style={
        { '--shape': width / height, background: colourOf(values.video_background) } as JSX.CSSProperties
      }
    >
      <ViewerStage label="The figure, as the film shows it" ready={setViewer} />
      <div class="film-drag" onPointerDown={drag} onPointerMove={drag} />
      {!pose && <p class="soft">The figure shows here once its mesh is made.</p>}
    </div>
  )
}

function Slider(props: {
  label: string
  value: number
  min: number
  max: number
  step?: number
  words: string
  set: (value: number) => void
}) {
  const id = `film-${props.label.replaceAll(' ', '-')}`
  return (
    <div class="film-slider">
      <label for={id}>{props.label}</label>
      <input
        id={id}
        type="range"
        min={props.min}
        max={props.max}
        step={props.step ?? 1}
        value={props.value}
        aria-valuetext={props.words}
        onInput={(event) => props.set(Number(event.currentTarget.value))}
      />
      <span class="number small">{props.words}</span>
    </div>
  )
}

function Camera({ values, set }: Editing) {
  const most = Number(values.video_azimuth) < 0
  const lens = lensOf(Number(values.video_fov))
  const [width, height] = [Number(values.video_width), Number(values.video_height)]
  const size = kSizes.findIndex(([, w, h]) => w === width && h === height)
  return (
    <section class="stack" aria-label="Camera">
      <Slider
        label="Side"
        value={azimuthOf(values)}
        min={0}
        max={359}
        words={most ? 'most motion' : `${azimuthOf(values)}°`}
        set={(value) => set({ video_azimuth: String(value) })}
      />
      <label class="row">
        <input
          type="checkbox"
          checked={most}
          onChange={(event) => set({ video_azimuth: event.currentTarget.checked ? '-1' : '0' })}
        />
        The side that shows most motion
      </label>
      <Slider
        label="Height"
        value={Number(values.video_elevation)}
        min={0}
        max={80}
        words={`${Number(values.video_elevation)}°`}
        set={(value) => set({ video_elevation: String(value) })}
      />
      <Slider
        label="Lens"
        value={Math.log(lens)}
        min={Math.log(14)}
        max={Math.log(300)}
        step={0.01}
        words={`${Math.round(lens)} mm`}
        set={(value) => set({ video_fov: fovOf(Math.exp(value)).toFixed(2) })}
      />
      <div class="film-slider">
        <label for="film-size">Size</label>
        <select
          id="film-size"
          value={size}
          onChange={(event) => {
            const [, w, h] = kSizes[Number(event.currentTarget.value)]
            set({ video_width: String(w), video_height: String(h) })
          }}
        >
          {size < 0 && <option value={-1}>{`${width} × ${height}`}</option>}
          {kSizes.map(([words], i) => (
            <option key={words} value={i}>
              {words}
            </option>
          ))}
        </select>
      </div>
    </section>
  )
}

function Look({ values, set }: Editing) {
  const named = kBackgrounds.some(([name]) => name === values.video_background)
  return (
    <section class="stack" aria-label="Light and background">
      <Slider
        label="Lamps"
        value={Number(values.video_light)}
        min={0}
        max={1}
        step={0.05}
        words={`${Math.round(100 * Number(values.video_light))} %`}
        set={(value) => set({ video_light: String(value) })}
      />
      <label class="row">
        <input
          type="checkbox"
          checked={values.video_shadow === 'true'}
          onChange={(event) => set({ video_shadow: String(event.currentTarget.checked) })}
        />
        A shadow on the table
      </label>
      <div class="film-slider">
        <label for="film-background">Background</label>
        <select
          id="film-background"
          value={named ? values.video_background : 'own'}
          onChange={(event) => {
            const { value } = event.currentTarget
            set({ video_background: value === 'own' ? colourOf(values.video_background) : value })
          }}
        >
          {kBackgrounds.map(([name, words]) => (
            <option key={name} value={name}>
              {words}
            </option>
          ))}
          <option value="own">Own colour</option>
        </select>
        {!named && (
          <input
            type="color"
            aria-label="Own colour"
            value={values.video_background}
            onInput={(event) => set({ video_background: event.currentTarget.value })}
          />
        )}
      </div>
    </section>
  )
}

function Length({ values, set }: Editing) {
  return (
    <section class="stack" aria-label="Length">
      <div class="film-slider">
        <label for="film-hold">Still at both ends</label>
        <input
          id="film-hold"
          type="number"
          min={0}
          max={1000}
          value={values.hold}
          onInput={(event) => {
            const { valueAsNumber } = event.currentTarget
            if (valueAsNumber >= 0) set({ hold: String(Math.round(valueAsNumber)) })
          }}
        />
        <span class="small soft">frames</span>
      </div>
      <label class="row">
        <input
          type="checkbox"
          checked={values.loop === 'pingpong'}
          onChange={(event) => set({ loop: event.currentTarget.checked ? 'pingpong' : 'none' })}
        />
        There and back
      </label>
      <p class="small soft">All else of its length is on the Timeline.</p>
    </section>
  )
}

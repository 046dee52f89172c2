// Mode 'Clicks': a frame of the film beside the mesh of its pose.
import { useEffect, useState } from 'preact/hooks'

import { useKeys } from '../../keys'
import { useStudio } from '../../state'
import { FrameView } from '../../view/frame_view'
import type { Mark } from '../../view/frame_view'
import type { Hit } from '../../view/viewer'
import { nameOf, nextName, replaced, without } from './click_file'
import { PoseView } from './pose_view'
import { shotApi } from './shot_api'
import type { Click, Film } from './shot_api'
import type { ShotDesk } from './use_shot'

type Pixel = [number, number]
interface Half {
  frame: number
  name: string
  pixel?: Pixel
  face?: number
  barycentric?: [number, number, number]
}

const onMesh = (hit: Hit) => ({ face: hit.face, barycentric: hit.barycentric })

/** What is done to clicks of one frame. */
export function useClicking(desk: ShotDesk, frame: number) {
  const { clicks: file } = desk
  const [pending, setPending] = useState<Half | null>(null)
  const [chosen, setChosen] = useState('')
  const [dragged, setDragged] = useState<{ name: string; pixel: Pixel } | null>(null)
  useEffect(() => {
    setPending(null)
    setChosen('')
  }, [frame])
  const named = file.clicks.map((click, index) => ({ click, index, name: nameOf(click, index) }))
  const here = named.filter(({ click }) => click.frame === frame)
  const find = (name: string) => here.find((one) => one.name === name)

  const complete = (half: Half) => {
    if (!half.pixel || half.face === undefined) return setPending(half)
    setPending(null)
    setChosen(half.name)
    file.change(`click ${half.name}`, [...file.clicks, half as Click])
  }
  const part = (): Half =>
    pending?.frame === frame ? pending : { frame, name: nextName(file.clicks) }
  const put = (name: string, change: Partial<Click>) => {
    const old = find(name)
    if (!old) return
    const { vertex: _, ...rest } = { ...old.click, ...change }
    const next = change.pixel ? { ...old.click, ...change } : rest
    file.change(`move ${name}`, replaced(file.clicks, old.index, next))
  }
  const remove = (name = chosen) => {
    if (pending && (name === '' || name === pending.name)) return setPending(null)
    const old = find(name)
    if (!old) return
    setChosen('')
    file.change(`delete ${name}`, without(file.clicks, old.index))
  }
  return {
    pending,
    chosen,
    here,
    dragged,
    choose: setChosen,
    cancel: () => (pending ? setPending(null) : setChosen('')),
    remove,
    pickPixel: (pixel: Pixel) => complete({ ...part(), pixel }),
    pickPlace: (hit: Hit) => complete({ ...part(), ...onMesh(hit) }),
    movePixel: (name: string, pixel: Pixel, done: boolean) => {
      setDragged(done ? null : { name, pixel })
      if (!done) return
      if (pending?.name === name) setPending({ ...pending, pixel })
      else put(name, { pixel })
    },
    movePlace: (name: string, hit: Hit) => {
      if (pending?.name === name) setPending({ ...pending, ...onMesh(hit) })
      else put(name, onMesh(hit))
    },
  }
}

export type Clicking = ReturnType<typeof useClicking>

/** One line: what to do next. */
export function hintOf(clicking: Clicking, pose: string): string {
  const { pending, chosen, here } = clicking
  if (pending?.pixel)
    return `${pending.name}: now click the same place on ${pose || 'the mesh'}. Esc cancels.`
  if (pending) return `${pending.name}: now click the same place in the frame. Esc cancels.`
  const left = 4 - here.length
  const more = left > 0 ? ` ${left} more make four, with which the camera is found.` : ''
  if (chosen) return `Drag ${chosen} to move it, here or on the mesh; Del deletes it.${more}`
  if (here.length === 0)
    return (
      'Needed only where the camera is not found by itself: click a place in the frame, then on ' +
      'the mesh.'
    )
  if (left > 0) return `The wheel looks closer.${more}`
  return 'Enough to find the camera. More places make it surer.'
}

export function ClickBench(props: {
  film: Film
  desk: ShotDesk
  clicking: Clicking
  frame: number
  /** a picture of the mesh's outlines over the frame, or '' */
  outlines: string
}) {
  const { film, desk, clicking, frame } = props
  const { project } = useStudio()
  const shown = film.shows.find((show) => show.frame === frame)?.pose ?? ''
  const pose = project.poses.find((one) => one.name === shown)
  const { pending, chosen, dragged } = clicking
  const at = (name: string, pixel: Pixel): Pixel => (dragged?.name === name ? dragged.pixel : pixel)
  const marks: Mark[] = clicking.here.map(({ name, click }) => ({
    name,
    pixel: at(name, click.pixel),
    chosen: name === chosen,
    pending: false,
  }))
  if (pending?.pixel)
    marks.push({
      name: pending.name,
      pixel: at(pending.name, pending.pixel),
      chosen: true,
      pending: true,
    })
  const places = clicking.here.map(({ name, click: { face, barycentric, vertex } }) => ({
    name,
    click: { face, barycentric, vertex },
    chosen: name === chosen,
  }))
  if (pending?.face !== undefined)
    places.push({
      name: pending.name,
      click: { face: pending.face, barycentric: pending.barycentric, vertex: undefined },
      chosen: true,
    })
  useKeys({
    Delete: () => clicking.remove(),
    Backspace: () => clicking.remove(),
    Escape: clicking.cancel,
    'ctrl+z': () => (pending ? clicking.cancel() : desk.clicks.undo()),
    'ctrl+shift+z': () => desk.clicks.redo(),
    'ctrl+y': () => desk.clicks.redo(),
  })
  return (
    <div class="shot-pair">
      <FrameView
        src={shotApi.frameUrl(frame, 0, film.film)}
        width={film.width}
        height={film.height}
        label={`Frame ${frame}`}
        help="Filmed frame: Space sets a mark in the middle, arrow keys move the chosen one"
        caption={film.frames.find((one) => one.frame === frame)?.name ?? ''}
        marks={marks}
        onPick={clicking.pickPixel}
        onChoose={clicking.choose}
        onMove={clicking.movePixel}
      >
        {props.outlines && (
          <image href={props.outlines} width={film.width} height={film.height} />
        )}
      </FrameView>
      <PoseView
        pose={pose}
        places={places}
        onPick={clicking.pickPlace}
        onChoose={clicking.choose}
        onMove={clicking.movePlace}
      />
    </div>
  )
}

/** The clicks of the frame as a list. */
export function ClickList({ clicking, desk }: { clicking: Clicking; desk: ShotDesk }) {
  const { clicks: file } = desk
  const words = file.failed ? 'Not saved' : file.saving ? 'Saving…' : 'Saved'
  return (
    <section class="stack" aria-label="Clicks">
      <div class="row spread">
        <h2 class="shot-title">Clicks of this frame</h2>
        <span class="shot-undo">
          <button
            class="quiet"
            aria-label="Undo"
            title="Undo (Ctrl Z)"
            disabled={!file.canUndo}
            onClick={() => file.undo()}
          >
            ↶
          </button>
          <button
            class="quiet"
            aria-label="Redo"
            title="Redo (Ctrl Shift Z)"
            disabled={!file.canRedo}
            onClick={() => file.redo()}
          >
            ↷
          </button>
        </span>
      </div>
      {clicking.here.length === 0 && <p class="small soft">None.</p>}
      <ul class="list shot-clicks">
        {clicking.here.map(({ name, click }) => (
          <li key={name}>
            <button
              aria-current={name === clicking.chosen ? 'true' : undefined}
              onClick={() => clicking.choose(name)}
            >
              <b>{name}</b>
              <span class="small soft number">
                {click.pixel.map((value) => value.toFixed(1)).join(', ')} px
              </span>
            </button>
            <button
              class="quiet"
              aria-label={`Delete click ${name}`}
              title="Delete (Del)"
              onClick={() => clicking.remove(name)}
            >
              ×
            </button>
          </li>
        ))}
      </ul>
      {file.failed ? (
        <p class="small bad">
          {file.failed}{' '}
          <button class="quiet" onClick={() => void file.save()}>
            Try again
          </button>
        </p>
      ) : (
        file.clicks.length > 0 && (
          <p class="small soft" role="status">
            {words}
          </p>
        )
      )}
    </section>
  )
}

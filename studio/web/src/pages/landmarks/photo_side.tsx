// The pose's photographs: one large with picks over it, all in a strip below.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import type { PhotoFit } from '../../api'
import { FrameView } from '../../view/frame_view'
import type { Mark, Zoom } from '../../view/frame_view'
import { Strip } from '../poses/strip'
import { useMaskOutline } from './mask_outline'
import { colorOf, contradictionOf, residualsOf, worstPlaces } from './photo_model'
import type { PhotoPicking } from './photo_picking'

type Pixel = [number, number]
export type Photograph = PhotoFit['photographs'][number]

/** Lines from picks to where the fitted model has them. */
function Residuals(props: { picking: PhotoPicking; fit: PhotoFit | null; image: string }) {
  return (
    <>
      {props.picking.pairs.map((pair, index) => {
        const one = residualsOf(pair, props.fit).find(({ pick }) => pick.image === props.image)
        if (!one) return null
        const [[x, y], [u, v]] = [one.pick.pixel, one.shown]
        return (
          <g key={pair.name} class="ph-residual" style={{ stroke: colorOf(index) }}>
            <line class="rim" x1={x} y1={y} x2={u} y2={v} />
            <line x1={x} y1={y} x2={u} y2={v} />
          </g>
        )
      })}
    </>
  )
}

/** Where the chosen pair lies by what is known of it. */
function Hints(props: { picking: PhotoPicking; fit: PhotoFit; image: string; size: number }) {
  const { picking, fit, image } = props
  const index = picking.pairs.findIndex((pair) => pair.name === picking.chosen)
  if (index < 0) return null
  const here = (one: { name: string; image: string }) =>
    one.name === picking.chosen && one.image === image
  const line = fit.lines.find(here)
  const meets = fit.meets.find(here)
  const shown = fit.shown.find((one) => here(one) && !one.hidden)
  const ring = 0.012 * props.size
  return (
    <g style={{ stroke: colorOf(index) }}>
      {line && (
        <g class="ph-line">
          <polyline class="rim" points={line.points.join(' ')} />
          <polyline points={line.points.join(' ')} />
        </g>
      )}
      {meets && <circle class="ph-meets" cx={meets.pixel[0]} cy={meets.pixel[1]} r={ring} />}
      {shown && (
        <path
          class="ph-shown"
          d={`M${shown.pixel[0] - ring} ${shown.pixel[1]}h${2 * ring}M${shown.pixel[0]} ${
            shown.pixel[1] - ring
          }v${2 * ring}`}
        />
      )}
    </g>
  )
}

/** A ring where the outlines of model and mask are farthest apart. */
function Worst({ fit, image, size }: { fit: PhotoFit | null; image: string; size: number }) {
  const place = worstPlaces(fit).find((one) => one.image === image)
  if (!place) return null
  const [cx, cy] = place.pixel
  return <circle class="ph-worst-ring" cx={cx} cy={cy} r={0.025 * size} />
}

function marksOf(picking: PhotoPicking, image: string, dragged: Mark | null): Mark[] {
  const marks = picking.pairs.flatMap((pair, index): Mark[] => {
    const pick = pair.pixels.find((one) => one.image === image)
    if (!pick) return []
    const chosen = pair.name === picking.chosen
    const color = chosen ? undefined : colorOf(index)
    return [{ name: pair.name, pixel: pick.pixel, chosen, pending: false, color }]
  })
  const { pending } = picking
  if (pending?.pixel && pending.image === image)
    marks.push({ name: pending.name, pixel: pending.pixel, chosen: true, pending: true })
  return marks.map((mark) => (mark.name === dragged?.name ? { ...mark, pixel: dragged.pixel } : mark))
}

/** One line on the chosen pair in this photograph, or ''. */
function wordsOf(picking: PhotoPicking, fit: PhotoFit, image: string): string {
  const { pair } = picking
  if (!pair) return ''
  const off = contradictionOf(pair, image, fit)
  if (off !== null)
    return `${pair.name}: ${off.toFixed(1)} px from where its other photographs have it (ring)`
  const here = (one: { name: string; image: string }) =>
    one.name === pair.name && one.image === image
  if (pair.pixels.some((one) => one.image === image)) return ''
  if (fit.meets.some(here)) return `${pair.name} must lie in the ring`
  if (fit.lines.some(here)) return `${pair.name} lies somewhere on the line`
  return ''
}

export function PhotoSide(props: {
  picking: PhotoPicking
  fit: PhotoFit
  photograph: Photograph
  show: (image: string) => void
  outline: boolean
  look: Zoom | null
}) {
  const { picking, fit, photograph } = props
  const { name, width, height } = photograph
  const size = Math.max(width, height)
  const [dragged, setDragged] = useState<Mark | null>(null)
  const outline = useMaskOutline(picking.pose, name, width, height, props.outline)
  const counts = new Map<string, number>()
  for (const pair of picking.pairs)
    for (const { image } of pair.pixels) counts.set(image, (counts.get(image) ?? 0) + 1)
  const note = (image: string) => {
    const one = fit.photographs.find((other) => other.name === image)
    const lost = one?.iou === null && fit.photographs.some((other) => other.iou !== null)
    return [counts.get(image), lost && 'no camera'].filter(Boolean).join(' · ')
  }
  const move = (mark: string, pixel: Pixel, done: boolean) => {
    setDragged(done ? null : { name: mark, pixel, chosen: false, pending: false })
    if (done) picking.movePixel(mark, pixel)
  }
  const words = wordsOf(picking, fit, name)
  return (
    <div class="ph-side">
      <FrameView
        src={api.photoUrl(picking.pose, name, 0, true, photograph.photograph)}
        width={width}
        height={height}
        label={`${picking.pose}: ${name}`}
        help="Photograph: Space sets a mark in the middle, arrow keys move the chosen one"
        caption={words || name}
        marks={marksOf(picking, name, dragged)}
        look={props.look}
        onPick={picking.pickPixel}
        onChoose={picking.choose}
        onMove={move}
      >
        {outline && <path class="ph-outline" d={outline} />}
        <Worst fit={fit} image={name} size={size} />
        {!dragged && <Residuals picking={picking} fit={fit} image={name} />}
        <Hints picking={picking} fit={fit} image={name} size={size} />
      </FrameView>
      <Strip
        src={(one) => api.photoUrl(picking.pose, one, 320, true)}
        label={`Photographs of ${picking.pose}`}
        names={fit.photographs.map((one) => one.name)}
        current={name}
        choose={props.show}
        note={note}
      />
    </div>
  )
}

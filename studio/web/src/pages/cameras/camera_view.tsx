// A camera's still picture: clicks of points, and after a calibration where it sees them.
import { useState } from 'preact/hooks'

import { FrameView } from '../../view/frame_view'
import type { Mark } from '../../view/frame_view'
import { Loupe } from './loupe'
import { pointsApi } from './points_api'
import type { CalibrationResult, ClickError, PointCamera } from './points_api'
import { clicksOf, errorOf, nextToClick, withClick } from './points_model'
import type { PointsDesk } from './use_points'

type Pixel = [number, number]

export function CameraView(props: {
  camera: PointCamera
  frame: number
  desk: PointsDesk
  result: CalibrationResult | null
  /** the point that a click places */
  chosen: string
  choose: (point: string) => void
}) {
  const { camera, desk, chosen, choose } = props
  const { points } = desk
  const [under, setUnder] = useState<Pixel | null>(null)
  const [dragged, setDragged] = useState<{ name: string; pixel: Pixel } | null>(null)
  const src = pointsApi.pictureUrl(camera, props.frame)
  // Clicks of a picture of another size are not mixed with those of this one.
  const closed = camera.problem !== ''
  const place = (name: string, pixel: Pixel) => {
    if (!closed) desk.change(`click ${name}`, withClick(points, camera.name, name, pixel))
  }
  const pick = (pixel: Pixel) => {
    if (!chosen || closed) return
    place(chosen, pixel)
    const next = nextToClick(withClick(points, camera.name, chosen, pixel), camera.name, chosen)
    if (next) choose(next)
  }
  const here = clicksOf(points, camera.name)
  const marks: Mark[] = here.map(({ point, pixel }) => ({
    name: point,
    pixel: dragged?.name === point ? dragged.pixel : pixel,
    chosen: point === chosen,
    pending: false,
    ...(errorOf(props.result, camera.name, point)?.wrong && { color: '#ff7a7a' }),
  }))
  return (
    <FrameView
      src={src}
      width={camera.width}
      height={camera.height}
      label={`Camera ${camera.name}`}
      help="Picture of a camera: the pointer or Space places the chosen point, arrow keys move it, the wheel looks closer"
      caption={`${camera.name}: ${camera.still}`}
      marks={marks}
      onPick={pick}
      onChoose={choose}
      onMove={(name, pixel, done) => {
        setDragged(done ? null : { name, pixel })
        setUnder(pixel)
        if (done) place(name, pixel)
      }}
      onHover={setUnder}
      aside={under && <Loupe src={src} width={camera.width} height={camera.height} pixel={under} />}
    >
      {here.map(({ point, pixel }) => {
        const error = errorOf(props.result, camera.name, point)
        if (!error || dragged?.name === point) return null
        return (
          <Error
            key={point}
            from={pixel}
            error={error}
            wide={Math.max(camera.width, camera.height) / 400}
          />
        )
      })}
    </FrameView>
  )
}

/** From a click to where the camera sees its point: a cross there, and how far it is. */
function Error(props: { from: Pixel; error: ClickError; wide: number }) {
  const { expected, error_px, wrong } = props.error
  const [x, y] = expected
  const arm = 2.2 * props.wide
  const cross = `M${x - arm} ${y - arm}l${2 * arm} ${2 * arm}M${x + arm} ${y - arm}l${-2 * arm} ${2 * arm}`
  const line = `M${props.from[0]} ${props.from[1]}L${x} ${y}`
  return (
    <g class={`cam-error ${wrong ? 'wrong' : ''}`}>
      <path class="under" d={line + cross} />
      <path d={line + cross} />
      <text x={x} y={y + 14 * props.wide} font-size={7 * props.wide} text-anchor="middle">
        {error_px.toFixed(1)} px
      </text>
    </g>
  )
}

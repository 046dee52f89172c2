// The points: their names and places, to be edited, and how far each click is off.
import { useState } from 'preact/hooks'

import type { CalibrationResult } from './points_api'
import {
  clickOf,
  errorOf,
  metresOf,
  moved,
  renamed,
  withoutClick,
  withoutPoint,
  withPoint,
} from './points_model'
import type { PointsDesk } from './use_points'

const kAxes = ['x', 'y', 'z']

/** A field that takes effect when it is left; what cannot be is put back. */
function Field(props: { value: string; label: string; set: (typed: string) => void }) {
  // What is being typed stays when the page is drawn again meanwhile.
  const [typed, setTyped] = useState<string | null>(null)
  const leave = () => {
    if (typed !== null && typed !== props.value) props.set(typed)
    setTyped(null)
  }
  return (
    <input
      value={typed ?? props.value}
      aria-label={props.label}
      onInput={(event) => setTyped(event.currentTarget.value)}
      onBlur={leave}
      onKeyDown={(event) => {
        if (event.key === 'Escape') setTyped(null)
        if (event.key === 'Enter') event.currentTarget.blur()
      }}
    />
  )
}

function PointRow(props: {
  name: string
  place: [number, number, number]
  desk: PointsDesk
  camera: string
  result: CalibrationResult | null
  chosen: boolean
  choose: (name: string) => void
}) {
  const { name, place, desk, camera, result } = props
  const { points } = desk
  const click = clickOf(points, camera, name)
  const error = errorOf(result, camera, name)
  const seen = result?.stale ? undefined : result?.points.find((one) => one.point === name)
  const number = points.clicks.filter((one) => one.point === name).length
  return (
    <tr aria-current={props.chosen ? 'true' : undefined}>
      <td>
        <button
          class="quiet cam-choose"
          aria-pressed={props.chosen}
          aria-label={`Click ${name} next`}
          title={click ? 'Clicked in this camera; a click moves it' : 'The next click places it'}
          onClick={() => props.choose(name)}
        >
          {click ? '●' : '○'}
        </button>
      </td>
      <td>
        <Field
          value={name}
          label={`Name of ${name}`}
          set={(typed) => {
            const next = renamed(points, name, typed)
            if (!next) return
            desk.change(`rename ${name}`, next)
            props.choose(typed.trim())
          }}
        />
      </td>
      {place.map((value, axis) => (
        <td key={axis}>
          <Field
            value={String(value)}
            label={`${kAxes[axis]} of ${name}, metres`}
            set={(typed) => {
              const metres = metresOf(typed)
              if (metres === null || metres === value) return
              desk.change(`move ${name}`, moved(points, name, axis, metres))
            }}
          />
        </td>
      ))}
      <td class="number" title="cameras in which it is clicked">
        {number}
      </td>
      <td class={`number ${error?.wrong ? 'bad' : ''}`} title={error?.wrong ? 'Left out' : ''}>
        {error ? error.error_px.toFixed(1) : ''}
      </td>
      <td class="number">{seen ? seen.apart_mm.toFixed(0) : ''}</td>
      <td>
        <button
          class="quiet"
          aria-label={`Remove ${name}`}
          title="Removes the point with its clicks"
          onClick={() => desk.change(`remove ${name}`, withoutPoint(points, name))}
        >
          ×
        </button>
      </td>
    </tr>
  )
}

export function PointTable(props: {
  desk: PointsDesk
  camera: string
  result: CalibrationResult | null
  chosen: string
  choose: (name: string) => void
}) {
  const { desk, camera, chosen } = props
  const { points, file } = desk
  const add = () => {
    const next = withPoint(points)
    desk.change('a point', next)
    props.choose(next.points[next.points.length - 1].name)
  }
  return (
    <section class="stack" aria-labelledby="cam-points-title">
      <div class="row spread">
        <h2 id="cam-points-title">Points</h2>
        <span>
          <button class="quiet small" disabled={!file.canUndo} onClick={() => void file.undo()}>
            Undo
          </button>
          <button class="quiet small" disabled={!file.canRedo} onClick={() => void file.redo()}>
            Redo
          </button>
        </span>
      </div>
      {points.points.length > 0 && (
        <table class="cam-table small">
          <thead>
            <tr>
              <th scope="col">
                <span class="hidden">Chosen</span>
              </th>
              <th scope="col">name</th>
              <th scope="col">x, m</th>
              <th scope="col">y</th>
              <th scope="col">z</th>
              <th scope="col" title="cameras in which it is clicked">
                in
              </th>
              <th scope="col" title="the click in this camera, from where the camera sees the point">
                px
              </th>
              <th scope="col" title="from where all cameras see the point to its place">
                mm
              </th>
              <th scope="col">
                <span class="hidden">Remove</span>
              </th>
            </tr>
          </thead>
          <tbody>
            {points.points.map((one) => (
              <PointRow
                key={one.name}
                name={one.name}
                place={one.place}
                chosen={one.name === chosen}
                {...{ desk, camera, result: props.result, choose: props.choose }}
              />
            ))}
          </tbody>
        </table>
      )}
      <div class="row">
        <button onClick={add}>Add a point</button>
        <button
          class="quiet"
          disabled={!clickOf(points, camera, chosen)}
          aria-keyshortcuts="Delete"
          onClick={() => desk.change(`take back ${chosen}`, withoutClick(points, camera, chosen))}
        >
          Take the click back
        </button>
      </div>
      {file.failed && <p class="bad small">Not saved: {file.failed}</p>}
    </section>
  )
}

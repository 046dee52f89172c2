// Pins and turns as rows to edit.
import type { ComponentChildren } from 'preact'

import type { Desk } from './desk'
import { Icon } from './icons'
import { NumberField } from './number_field'
import {
  deletePin,
  deleteTurn,
  kAxes,
  keyOfPin,
  kMostTurns,
  pinsOf,
  setPin,
  setTurn,
  turnsOf,
} from './region_model'
import type { Axis, Pin, Turn } from './region_model'
import { framesOf } from './timeline_model'

function Choice(props: {
  label: string
  value: string
  change: (value: string) => void
  children: ComponentChildren
}) {
  return (
    <select
      aria-label={props.label}
      value={props.value}
      onChange={(event) => props.change(event.currentTarget.value)}
    >
      {props.children}
    </select>
  )
}

function RegionChoice(props: {
  label: string
  regions: string[]
  region: string
  change: (region: string) => void
}) {
  const known = props.regions.includes(props.region)
  return (
    <Choice label={props.label} value={props.region} change={props.change}>
      {!known && <option value={props.region}>{props.region}</option>}
      {props.regions.map((name) => (
        <option key={name} value={name}>
          {name}
        </option>
      ))}
    </Choice>
  )
}

const kEnd = 'end'

/** One end of a pin: a key, or the end of the whole timeline. */
function PinEnd(props: { desk: Desk; pin: Pin; index: number; end: 'from' | 'to' }) {
  const { desk, pin, index, end } = props
  const { timeline } = desk
  const frames = framesOf(timeline)
  const seconds = pin[end]
  const key = seconds === undefined ? kEnd : String(keyOfPin(timeline, seconds))
  const change = (value: string) =>
    desk.edit((now) =>
      setPin(now, index, { [end]: value === kEnd ? undefined : now.keys[Number(value)].at }),
    )
  const label = `Pin ${index + 1} ${end === 'from' ? 'begins' : 'ends'}`
  return (
    <Choice label={label} value={key} change={change}>
      {key === '-1' && <option value="-1">{`no key at ${seconds!.toFixed(2)} s`}</option>}
      <option value={kEnd}>{end === 'from' ? 'the start' : 'the end'}</option>
      {timeline.keys.map((one, i) => (
        <option key={i} value={String(i)}>
          {`${frames[i]} ${one.pose}`}
        </option>
      ))}
    </Choice>
  )
}

function Delete({ label, act }: { label: string; act: () => void }) {
  return (
    <td>
      <button class="quiet" aria-label={label} onClick={act}>
        <Icon name="bin" />
      </button>
    </td>
  )
}

function Head({ columns }: { columns: string[] }) {
  return (
    <thead>
      <tr>
        {columns.map((name) => (
          <th key={name} scope="col">
            {name}
          </th>
        ))}
        <th>
          <span class="hidden">Delete</span>
        </th>
      </tr>
    </thead>
  )
}

export function PinRows({ desk, regions }: { desk: Desk; regions: string[] }) {
  const pins = pinsOf(desk.timeline)
  if (pins.length === 0) return null
  return (
    <table class="tl-table tl-rules">
      <Head columns={['Stays put', 'from', 'to']} />
      <tbody>
        {pins.map((pin, index) => (
          <tr key={index}>
            <td>
              <RegionChoice
                label={`Region of pin ${index + 1}`}
                regions={regions}
                region={pin.region}
                change={(region) => desk.edit((now) => setPin(now, index, { region }))}
              />
            </td>
            <td>
              <PinEnd desk={desk} pin={pin} index={index} end="from" />
            </td>
            <td>
              <PinEnd desk={desk} pin={pin} index={index} end="to" />
            </td>
            <Delete
              label={`Delete pin ${index + 1}`}
              act={() => desk.edit((now) => deletePin(now, index))}
            />
          </tr>
        ))}
      </tbody>
    </table>
  )
}

const axisOf = (turn: Turn): string => {
  if (!turn.axis) return ''
  const name = Object.entries(kAxes).find(([, axis]) => axis.join() === turn.axis!.join())?.[0]
  return name ?? turn.axis.join(', ')
}

function AxisChoice({ desk, turn, index }: { desk: Desk; turn: Turn; index: number }) {
  const axis = axisOf(turn)
  const change = (value: string) =>
    desk.edit((now) => setTurn(now, index, { axis: kAxes[value as Axis] }))
  return (
    <Choice label={`Axis of turn ${index + 1}`} value={axis} change={change}>
      <option value="">as it moves</option>
      {Object.keys(kAxes).map((name) => (
        <option key={name} value={name}>
          {name}
        </option>
      ))}
      {axis.length > 1 && <option value={axis}>{axis}</option>}
    </Choice>
  )
}

export function TurnRows({ desk, regions }: { desk: Desk; regions: string[] }) {
  const { timeline } = desk
  const turns = turnsOf(timeline)
  const frames = framesOf(timeline)
  if (turns.length === 0) return null
  return (
    <table class="tl-table tl-rules">
      <Head columns={['Turns', 'after', 'times', 'about']} />
      <tbody>
        {turns.map((turn, index) => (
          <tr key={`${turn.key} ${turn.region}`}>
            <td>
              <RegionChoice
                label={`Region of turn ${index + 1}`}
                regions={regions}
                region={turn.region}
                change={(region) => desk.edit((now) => setTurn(now, index, { region }))}
              />
            </td>
            <td>
              <Choice
                label={`Key of turn ${index + 1}`}
                value={String(turn.key)}
                change={(key) => desk.edit((now) => setTurn(now, index, { key: Number(key) }))}
              >
                {timeline.keys.slice(0, -1).map((one, i) => (
                  <option key={i} value={String(i)}>
                    {`${frames[i]} ${one.pose}`}
                  </option>
                ))}
              </Choice>
            </td>
            <td>
              <NumberField
                label={`Turns of turn ${index + 1}`}
                value={turn.turns}
                min={-kMostTurns}
                max={kMostTurns}
                change={(count) => desk.edit((now) => setTurn(now, index, { turns: count }))}
              />
            </td>
            <td>
              <AxisChoice desk={desk} turn={turn} index={index} />
            </td>
            <Delete
              label={`Delete turn ${index + 1}`}
              act={() => desk.edit((now) => deleteTurn(now, index))}
            />
          </tr>
        ))}
      </tbody>
    </table>
  )
}

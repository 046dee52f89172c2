// Pins and turns of regions, to edit; and what else the file says of regions, to read.
import { useEffect, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Timeline } from '../../api'
import { useStudio } from '../../state'
import type { Desk } from './desk'
import { addPin, addTurn, listOf, regionNames } from './region_model'
import { PinRows, TurnRows } from './region_rows'

interface Line {
  region: string
  what: string
  when: string
}

type Fields = Record<string, unknown>

const seconds = (value: unknown) => `${Number(value).toFixed(2)} s`

function pathLine(path: Fields): Line {
  const points = listOf(path.points)
  const when = points.map((point) => seconds(point.time)).join(', ')
  const what = `passes ${points.length} place${points.length === 1 ? '' : 's'}`
  return { region: String(path.region), what, when }
}

function wholeLines(other: Fields): Line[] {
  const lines: Line[] = []
  const add = (what: string, when = '') =>
    lines.push({ region: 'all of it', what, when })
  if (other.table !== undefined) add(`stays above the table at z = ${String(other.table)}`)
  if (other.overshoot === true) add('may swing a little beyond keys')
  if (typeof other.volume === 'boolean')
    add(other.volume ? 'volume follows the keys' : 'volume is free')
  for (const one of listOf(other.volume))
    add(`volume × ${String(one.ratio)}`, `at ${seconds(one.time)}`)
  return lines
}

/** What this page shows and keeps, but does not edit. */
function Others({ timeline }: { timeline: Timeline }) {
  const { other } = timeline
  const lines = [...listOf(other.trajectories).map(pathLine), ...wholeLines(other)]
  if (lines.length === 0) return null
  return (
    <table class="tl-table tl-others">
      <caption class="small soft">
        From the project’s file, <span class="mono">pipeline.yaml</span>; kept as it is
      </caption>
      <tbody>
        {lines.map((line, i) => (
          <tr key={i}>
            <td class="tl-plain">{line.region}</td>
            <td>{line.what}</td>
            <td class="number">{line.when}</td>
          </tr>
        ))}
      </tbody>
    </table>
  )
}

/** Names of the regions that are painted on the page Landmarks. */
function usePainted(): string[] {
  const { project, version, complain } = useStudio()
  const [names, setNames] = useState<string[]>([])
  const there = project.poses.some((pose) => pose.template && pose.meshes.includes('mesh'))
  useEffect(() => {
    let alive = true
    if (there)
      api
        .regions()
        .then(({ regions }) => alive && setNames(Object.keys(regions)))
        .catch((error) => alive && complain(error))
    return () => {
      alive = false
    }
  }, [there, version, complain])
  return names
}

export function RegionsTable({ desk }: { desk: Desk }) {
  const painted = usePainted()
  const [chosen, choose] = useState('')
  const regions = regionNames(desk.timeline, painted)
  const region = regions.includes(chosen) ? chosen : regions[0]
  const span = Math.min(desk.selected, desk.timeline.keys.length - 2)
  return (
    <div class="stack tl-regions">
      {regions.length === 0 ? (
        <p class="soft">
          Paint a region on the figure, such as a foot or a propeller: it can then stay put, or
          turn, between keys. <a href="#/landmarks">Paint one</a>
        </p>
      ) : (
        <div class="row tl-add">
          <select
            aria-label="Region"
            value={region}
            onChange={(event) => choose(event.currentTarget.value)}
          >
            {regions.map((name) => (
              <option key={name} value={name}>
                {name}
              </option>
            ))}
          </select>
          <button onClick={() => desk.edit((now) => addPin(now, region))}>Pin it</button>
          <button onClick={() => desk.edit((now) => addTurn(now, region, span))}>Turn it</button>
        </div>
      )}
      <PinRows desk={desk} regions={regions} />
      <TurnRows desk={desk} regions={regions} />
      <Others timeline={desk.timeline} />
    </div>
  )
}

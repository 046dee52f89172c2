// What the file says of regions: turns, pins, paths. Shown, not edited.
import type { Timeline } from '../../api'
import { framesOf, keysOf } from './timeline_model'

interface Line {
  region: string
  what: string
  when: string
  /** why it will not work as it is, or '' */
  wrong: string
}

type Fields = Record<string, unknown>

const listOf = (value: unknown): Fields[] =>
  Array.isArray(value) ? value.filter((one) => typeof one === 'object' && one !== null) : []
const seconds = (value: unknown) => `${Number(value).toFixed(2)} s`

function turnLines(timeline: Timeline): Line[] {
  const frames = framesOf(timeline)
  return keysOf(timeline).flatMap((key, i) =>
    Object.entries(key.turns ?? {}).map(([region, value]) => {
      const fields = (typeof value === 'object' && value !== null ? value : {}) as Fields
      const count = Number(fields.turns ?? value)
      const axis = Array.isArray(fields.axis) ? ` about ${fields.axis.join(', ')}` : ''
      const what = `${count} more turn${Math.abs(count) === 1 ? '' : 's'}${axis}`
      return { region, what, when: `from frame ${frames[i]}`, wrong: '' }
    }),
  )
}

/** Pins run from key to key; a key that has moved on leaves them behind. */
function pinLine(timeline: Timeline, pin: Fields): Line {
  const lost = [pin.from, pin.to].find(
    (time) =>
      time !== undefined &&
      !timeline.keys.some((key) => Math.abs(key.at - Number(time)) * timeline.fps < 0.5),
  )
  const from = pin.from === undefined ? 'the start' : seconds(pin.from)
  const to = pin.to === undefined ? 'the end' : seconds(pin.to)
  return {
    region: String(pin.region),
    what: 'pinned',
    when: `${from} to ${to}`,
    wrong: lost === undefined ? '' : `there is no key at ${seconds(lost)}`,
  }
}

function pathLine(path: Fields): Line {
  const points = listOf(path.points)
  const when = points.map((point) => seconds(point.time)).join(', ')
  const what = `passes ${points.length} place${points.length === 1 ? '' : 's'}`
  return { region: String(path.region), what, when, wrong: '' }
}

function regionLine(region: Fields): Line {
  const vertices = Array.isArray(region.vertices) ? region.vertices.length : 0
  const what = vertices > 0 ? `${vertices} vertices` : `ball of radius ${String(region.radius)}`
  return { region: String(region.name), what, when: '', wrong: '' }
}

function wholeLines(other: Fields): Line[] {
  const lines: Line[] = []
  const add = (what: string, when = '') =>
    lines.push({ region: 'all of it', what, when, wrong: '' })
  if (other.table !== undefined) add(`stays above the table at z = ${String(other.table)}`)
  if (other.overshoot === true) add('may swing a little beyond keys')
  if (typeof other.volume === 'boolean')
    add(other.volume ? 'volume follows the keys' : 'volume is free')
  for (const one of listOf(other.volume))
    add(`volume × ${String(one.ratio)}`, `at ${seconds(one.time)}`)
  return lines
}

function linesOf(timeline: Timeline): Line[] {
  const { other } = timeline
  return [
    ...listOf(other.regions).map(regionLine),
    ...turnLines(timeline),
    ...listOf(other.pins).map((pin) => pinLine(timeline, pin)),
    ...listOf(other.trajectories).map(pathLine),
    ...wholeLines(other),
  ]
}

export function RegionsTable({ timeline }: { timeline: Timeline }) {
  const lines = linesOf(timeline)
  return (
    <div class="stack tl-regions">
      {lines.length > 0 && (
        <table class="tl-table">
          <thead>
            <tr>
              <th scope="col">Region</th>
              <th scope="col">What</th>
              <th scope="col">When</th>
            </tr>
          </thead>
          <tbody>
            {lines.map((line, i) => (
              <tr key={i}>
                <td class="tl-plain">{line.region}</td>
                <td>{line.what}</td>
                <td class="number">
                  {line.when}
                  {line.wrong && <span class="warn"> – {line.wrong}</span>}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <p class="soft small">
        {lines.length === 0 && 'No turns, pins or paths yet. '}
        Regions, turns, pins and paths are written under <span class="mono">timeline</span> in{' '}
        <span class="mono">pipeline.yaml</span>; this page shows them and keeps them as they are.
      </p>
    </div>
  )
}

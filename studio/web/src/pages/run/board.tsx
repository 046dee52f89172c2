// All steps at a glance: a row for each step of the pipeline, a column for each pose.
import { useRef, useState } from 'preact/hooks'

import type { Step } from '../../api'
import { useStudio } from '../../state'
import { cssShare, duration, percent } from '../../words'
import { isFromMesh } from '../poses/tabs'
import { Icon } from './icons'
import { kStateWords, rowsOf, shownState } from './step_words'
import type { Row } from './step_words'

/** Pure: the words at the right of a cell. */
function detailOf(step: Step): string {
  if (step.state === 'done') return step.seconds > 0 ? duration(step.seconds) : ''
  if (step.state === 'failed') return step.error.split('\n')[0]
  if (step.state === 'waits' && step.waits_for.length > 0) return `for ${step.waits_for[0]}`
  if (step.state === 'would_run') return step.reasons[0]?.replace(' -> ', ' → ') ?? ''
  return ''
}

function CellWords({ step }: { step: Step }) {
  const { running } = useStudio()
  const work = running?.steps[step.id]
  if (!work)
    return (
      <>
        <Icon name={step.state} />
        <span class="word">{kStateWords[step.state]}</span>
        <span class="detail number">{detailOf(step)}</span>
      </>
    )
  return (
    <>
      <Icon name="running" />
      <span class="word number">
        <span class="hidden">running </span>
        {percent(work.fraction)}
      </span>
      <span class="detail">{work.what}</span>
      <span class="progress" aria-hidden="true">
        <i style={{ width: cssShare(work.fraction) }} />
      </span>
    </>
  )
}

function Cell(props: {
  step: Step
  span: number
  selected: boolean
  /** the one cell that the Tab key reaches */
  reached: boolean
  fresh: boolean
  open: (id: string) => void
}) {
  const { running } = useStudio()
  const { step } = props
  const title = [step.id, kStateWords[shownState(step, running)], detailOf(step)]
  return (
    <td
      role="gridcell"
      data-id={step.id}
      colSpan={props.span}
      tabIndex={props.reached ? 0 : -1}
      aria-selected={props.selected}
      class={props.fresh ? 'fresh' : ''}
      title={title.filter(Boolean).join(': ')}
      onClick={() => props.open(step.id)}
    >
      <div class={`cell ${shownState(step, running)} ${step.pose ? '' : 'wide'}`}>
        <CellWords step={step} />
      </div>
    </td>
  )
}

function PoseHead({ pose }: { pose: string }) {
  const { project, steps } = useStudio()
  const known = project.poses.find((one) => one.name === pose)
  const verdict = steps.verdicts.find((one) => one.about === pose)
  const facts: string[] = []
  if (known && project.kind === 'poses') {
    facts.push(isFromMesh(known) ? 'mesh' : `${known.photographs} photos`)
    if (known.template) facts.push('gives its net')
  }
  return (
    <th scope="col">
      <div class="pose">
        <b title={pose}>{pose}</b>
        <p>
          {verdict && (
            <span class={`grade ${verdict.grade}`} title={verdict.why}>
              <Icon name={verdict.grade} />
              {verdict.grade}
            </span>
          )}
          <small>{facts.join(', ')}</small>
        </p>
      </div>
    </th>
  )
}

/** The cell that an arrow key leads to from column `at`; a wide cell counts for every column. */
function neighbour(
  rows: Row[],
  poses: string[],
  id: string,
  key: string,
  at: number,
): string | null {
  const place = rows.findIndex((row) => [...row.cells.values()].some((one) => one.id === id))
  if (place < 0) return null
  const pick = (row: Row | undefined, pose: number) =>
    (row?.cells.get(poses[pose]) ?? row?.cells.get(''))?.id ?? null
  if (key === 'ArrowRight' || key === 'ArrowLeft' || key === 'Home' || key === 'End') {
    const row = rows[place]
    const columns = poses.map((_, i) => i).filter((i) => row.cells.has(poses[i]))
    if (key === 'Home') return pick(row, columns[0])
    if (key === 'End') return pick(row, columns[columns.length - 1])
    const here = columns.findIndex((i) => row.cells.get(poses[i])?.id === id)
    const next = columns[here + (key === 'ArrowRight' ? 1 : -1)]
    return here < 0 || next === undefined ? null : pick(row, next)
  }
  const direction = key === 'ArrowDown' ? 1 : -1
  // A row without this pose (the template's unwrap, a pair's register) gives its nearest cell.
  const row = rows[place + direction]
  return pick(row, at) ?? [...(row?.cells.values() ?? [])][0]?.id ?? null
}

/** Narrower columns than this make the board scroll. */
const kNameWidth = 232
const kPoseWidth = 118

const kMoves = ['ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight', 'Home', 'End']

export function Board(props: {
  selected: string
  fresh: string[]
  open: (id: string, byKey: boolean) => void
  summaries: Map<string, string>
}) {
  const { project, steps } = useStudio()
  const table = useRef<HTMLTableElement>(null)
  const [reached, setReached] = useState('')
  // Kept while moving up and down past rows that do not have this pose.
  const column = useRef(0)
  const rows = rowsOf(steps.steps)
  const poses = project.poses.map((pose) => pose.name)
  const ids = new Set(steps.steps.map((step) => step.id))
  const tabStop = [reached, props.selected].find((id) => ids.has(id)) ?? steps.steps[0]?.id ?? ''

  const keepColumn = (id: string) => {
    const pose = steps.steps.find((step) => step.id === id)?.pose
    if (pose) column.current = Math.max(0, poses.indexOf(pose))
  }
  const onKeyDown = (event: KeyboardEvent) => {
    const id = (event.target as HTMLElement).dataset.id
    if (!id || event.ctrlKey || event.metaKey || event.altKey) return
    if (event.key === 'Enter' || event.key === ' ') {
      event.preventDefault()
      props.open(id, true)
    } else if (kMoves.includes(event.key)) {
      event.preventDefault()
      const next = neighbour(rows, poses, id, event.key, column.current)
      if (!next) return
      setReached(next)
      if (!event.key.endsWith('Up') && !event.key.endsWith('Down')) keepColumn(next)
      table.current?.querySelector<HTMLElement>(`[data-id="${CSS.escape(next)}"]`)?.focus()
    }
  }
  const cell = (step: Step, span: number) => (
    <Cell
      key={step.id}
      step={step}
      span={span}
      selected={step.id === props.selected}
      reached={step.id === tabStop}
      fresh={props.fresh.includes(step.id)}
      open={(id) => {
        setReached(id)
        keepColumn(id)
        props.open(id, false)
      }}
    />
  )
  return (
    <div class="run-board">
      <table
        ref={table}
        role="grid"
        aria-label="Steps by pose"
        style={{ minWidth: `${kNameWidth + kPoseWidth * poses.length}px` }}
        onKeyDown={onKeyDown}
      >
        <thead>
          <tr>
            <th scope="col" class="name">
              <span class="hidden">Step</span>
            </th>
            {poses.map((pose) => (
              <PoseHead key={pose} pose={pose} />
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => {
            const all = row.cells.get('')
            return (
              <tr key={row.step}>
                <th scope="row" class="name" title={props.summaries.get(row.step)}>
                  <span>{row.title}</span>
                  {row.title !== row.step && <code>{row.step}</code>}
                </th>
                {all
                  ? cell(all, Math.max(1, poses.length))
                  : poses.map((pose) => {
                      const step = row.cells.get(pose)
                      if (step) return cell(step, 1)
                      return <td key={pose} role="gridcell" class="none" aria-label="not needed" />
                    })}
              </tr>
            )
          })}
        </tbody>
      </table>
    </div>
  )
}

// Steps and their states in words.
import type { Step, StepState } from '../../api'
import type { Running } from '../../run_lines'

export type Shown = StepState | 'running'

export const kStateWords: Record<Shown, string> = {
  done: 'done',
  would_run: 'would run',
  waits: 'waits',
  failed: 'failed',
  never: 'never ran',
  missing: 'missing',
  running: 'running',
}

export function shownState(step: Step, running: Running | null): Shown {
  return running?.steps[step.id] ? 'running' : step.state
}

export interface Row {
  step: string
  /** what an artist calls its work */
  title: string
  /** by pose; '' is a step of the animation or of the project */
  cells: Map<string, Step>
}

/** Rows of the board: steps in the order of the pipeline, one row for all poses. */
export function rowsOf(steps: Step[]): Row[] {
  const rows = new Map<string, Row>()
  for (const step of steps) {
    const row = rows.get(step.step) ?? { step: step.step, title: step.title, cells: new Map<string, Step>() }
    row.cells.set(step.pose, step)
    rows.set(step.step, row)
  }
  return [...rows.values()]
}

/** "dense/rest, dense/bent and 3 more" */
export function some(names: string[], shown = 3): string {
  if (names.length <= shown + 1) return names.join(', ')
  return `${names.slice(0, shown).join(', ')} and ${names.length - shown} more`
}

/** "2 steps would run again, 14 wait for them": what a change of an option has set off. */
export function effectOf(before: Step[], after: Step[]): { ids: string[]; text: string } {
  const old = new Map(before.map((step) => [step.id, step.state]))
  const changed = after.filter((step) => old.get(step.id) !== step.state)
  const ids = changed.map((step) => step.id)
  const run = changed.filter((step) => step.state === 'would_run').map((step) => step.id)
  const wait = changed.filter((step) => step.state === 'waits').length
  const done = changed.filter((step) => step.state === 'done').length
  const parts: string[] = []
  if (run.length > 0) parts.push(`${some(run, 2)} would run again`)
  if (wait > 0) parts.push(`${wait} ${wait === 1 ? 'waits' : 'wait'} for that`)
  if (done > 0) parts.push(`${done} ${done === 1 ? 'is' : 'are'} up to date again`)
  return { ids, text: parts.join('; ') || 'No step’s state changes' }
}

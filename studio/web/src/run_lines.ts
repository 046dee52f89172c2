// A run's state, from the lines that `keypose run --progress jsonl` prints.
import type { RunLine } from './api'
import { durationRange } from './words'

export interface Running {
  /** [0, 1] of the whole run */
  overall: number
  /** in words, "2 to 5 min"; null while nothing is known of it */
  left: string | null
  /** fraction and words by step that is at work */
  steps: Record<string, { fraction: number; what: string }>
  /** steps that this run has finished, with their status */
  finished: Record<string, string>
  notes: string[]
}

export const kNoRun: Running = {
  overall: 0,
  left: null,
  steps: {},
  finished: {},
  notes: [],
}

function leftIn({ seconds_left: likely, seconds_left_range: range }: RunLine): string | null {
  return likely === undefined ? null : durationRange(likely, range ?? [likely, likely])
}

/** The run's state after one more line. */
export function afterLine(run: Running, line: RunLine): Running {
  const next: Running = {
    ...run,
    overall: line.overall ?? run.overall,
    left: leftIn(line),
  }
  const step = line.step
  if (line.event === 'start' && step)
    next.steps = { ...run.steps, [step]: { fraction: 0, what: 'starts' } }
  if (line.event === 'progress' && step)
    next.steps = {
      ...run.steps,
      [step]: { fraction: line.fraction ?? 0, what: line.what ?? '' },
    }
  if (line.event === 'finish' && step) {
    const { [step]: _, ...others } = run.steps
    next.steps = others
    next.finished = { ...run.finished, [step]: line.status ?? '' }
  }
  if (line.event === 'note' && line.text) next.notes = [...run.notes.slice(-50), line.text]
  return next
}

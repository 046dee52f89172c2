// The frames of the last run, and whether the timeline has moved on since.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Frames, Step, Timeline } from '../../api'
import { useStudio } from '../../state'
import { framesFit } from './timeline_model'

export interface Made {
  frames: Frames
  /** one view each into a single array, so that playing allocates nothing */
  positions: Float32Array[]
}

async function readFrames(frames: Frames): Promise<Made> {
  const all = await api.positions()
  const size = 3 * frames.vertices
  if (all.length !== size * frames.count)
    throw new Error('The frames have changed while they were read; look again in a moment.')
  const positions = Array.from({ length: frames.count }, (_, i) =>
    all.subarray(i * size, (i + 1) * size),
  )
  return { frames, positions }
}

/** `ready` is false until the server was asked once. */
export function useFrames(): { made: Made | null; ready: boolean } {
  const { project, version, complain } = useStudio()
  const [made, setMade] = useState<Made | null>(null)
  const [ready, setReady] = useState(false)
  const known = useRef('')
  useEffect(() => {
    let current = true
    const load = async () => {
      if (!project.has_frames) {
        known.current = ''
        setMade(null)
        return
      }
      const frames = await api.frames()
      // Area and volume of every frame tell whether the positions are the ones we have.
      const signature = JSON.stringify(frames)
      if (!current || signature === known.current) return
      const read = await readFrames(frames)
      if (!current) return
      known.current = signature
      setMade(read)
    }
    const failed = (error: unknown) => {
      if (current) complain(error)
    }
    void load()
      .catch(failed)
      .finally(() => current && setReady(true))
    return () => {
      current = false
    }
  }, [version, project.has_frames, complain])
  return { made, ready }
}

export const interpolateStep = (steps: Step[]): Step | undefined =>
  steps.find((step) => step.step === 'interpolate')

/** True if the shown frames are not those that the timeline asks for. */
export function useStale(timeline: Timeline, order: boolean, made: Made | null): boolean {
  const { steps } = useStudio()
  if (!made) return false
  const step = interpolateStep(steps.steps)
  const planned = step !== undefined && step.state !== 'done'
  return planned || (!order && !framesFit(timeline, made.frames))
}

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

async function readFrames(frames: Frames, shot: string): Promise<Made> {
  const all = await api.positions(shot)
  const size = 3 * frames.vertices
  if (all.length !== size * frames.count)
    throw new Error('The frames have changed while they were read; look again in a moment.')
  const positions = Array.from({ length: frames.count }, (_, i) =>
    all.subarray(i * size, (i + 1) * size),
  )
  return { frames, positions }
}

/** Of a performance's shot, or of the animation. `ready` is false until the server was asked once. */
export function useFrames(shot = ''): { made: Made | null; ready: boolean } {
  const { project, version, complain } = useStudio()
  const there = shot
    ? (project.poses.find((pose) => pose.name === shot)?.has_frames ?? false)
    : project.has_frames
  const [made, setMade] = useState<Made | null>(null)
  const [ready, setReady] = useState(false)
  const known = useRef('')
  useEffect(() => {
    let current = true
    const load = async () => {
      if (!there) {
        known.current = ''
        setMade(null)
        return
      }
      const frames = await api.frames(shot)
      // Area and volume of every frame tell whether the positions are the ones we have.
      const signature = JSON.stringify(frames)
      if (!current || signature === known.current) return
      const read = await readFrames(frames, shot)
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
  }, [version, there, shot, complain])
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

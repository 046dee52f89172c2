// The points of the project: read when it changes, written at once.
import { useEffect, useMemo, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { useUnsavedGuard } from '../poses/route'
import { ClickFile } from '../shot/click_file'
import { pointsApi } from './points_api'
import type { Calibration, Points } from './points_api'

export interface PointsDesk {
  /** null: not read yet */
  calibration: Calibration | null
  points: Points
  file: ClickFile<Points>
  change: (what: string, points: Points) => void
  take: (now: Calibration) => void
}

const kNone: Points = { points: [], clicks: [] }
const pointsOf = ({ points, clicks }: Calibration): Points => ({ points, clicks })

export function usePoints(): PointsDesk {
  const { version, tell, complain } = useStudio()
  const [calibration, setCalibration] = useState<Calibration | null>(null)
  const [, drawAgain] = useState(0)
  // One state of all points as the only item of a list: that gives undo and saving in turn.
  const file = useMemo(() => {
    const store = {
      save: async (list: readonly Points[], revision: string) => {
        const now = await pointsApi.save(list[0] ?? kNone, revision)
        setCalibration(now)
        return now.revision
      },
      read: async () => {
        const now = await pointsApi.read()
        setCalibration(now)
        return { clicks: [pointsOf(now)], revision: now.revision }
      },
    }
    return new ClickFile<Points>(store, () => drawAgain((old) => old + 1), tell, 'points')
  }, [tell])
  const take = (now: Calibration, asked?: number) => {
    setCalibration(now)
    file.take([pointsOf(now)], now.revision, asked)
  }
  useEffect(() => {
    let current = true
    const asked = file.moment
    pointsApi.read().then(
      (now) => {
        if (!current) return
        take(now, asked)
        if (file.failed) void file.save()
      },
      (error: unknown) => current && complain(error),
    )
    return () => {
      current = false
    }
  }, [version, file, complain])
  useUnsavedGuard(file.failed !== '')
  return {
    calibration,
    points: file.clicks[0] ?? kNone,
    file,
    change: (what, points) => file.change(what, [points]),
    take,
  }
}

// What is said of a pose's figure: read when the project changes, written at once.
import { useEffect, useMemo, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Figure, FigureStroke } from '../../api'
import { useStudio } from '../../state'
import { ClickFile } from '../shot/click_file'
import { useUnsavedGuard } from './route'

export interface FigureDesk {
  /** null: not read yet */
  figure: Figure | null
  strokes: ClickFile<FigureStroke>
}

export function useFigure(pose: string): FigureDesk {
  const { version, tell, complain } = useStudio()
  const [figure, setFigure] = useState<Figure | null>(null)
  const [, drawAgain] = useState(0)
  const strokes = useMemo(() => {
    const store = {
      save: async (list: readonly FigureStroke[], revision: string) => {
        const now = await api.saveFigure(pose, list, revision)
        setFigure(now)
        return now.revision
      },
      read: async () => {
        const now = await api.figure(pose)
        setFigure(now)
        return { clicks: now.strokes, revision: now.revision }
      },
    }
    return new ClickFile<FigureStroke>(store, () => drawAgain((old) => old + 1), tell, 'strokes')
  }, [pose, tell])
  useEffect(() => {
    let current = true
    const asked = strokes.moment
    api.figure(pose).then(
      (now) => {
        if (!current) return
        setFigure(now)
        strokes.take(now.strokes, now.revision, asked)
        // A stroke that could not be saved, perhaps as the studio was away, is tried again.
        if (strokes.failed) void strokes.save()
      },
      (error: unknown) => current && complain(error),
    )
    return () => {
      current = false
    }
  }, [pose, version, strokes, complain])
  useUnsavedGuard(strokes.failed !== '')
  return { figure, strokes }
}

// What is mended on a pose's mesh: read when the project changes, written at once, drafted by the
// server.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Mending, MendStroke } from '../../api'
import { useStudio } from '../../state'
import { parseMesh } from '../../view/mesh_data'
import type { MeshData } from '../../view/mesh_data'
import { ClickFile } from '../shot/click_file'
import { draftFrom } from './mend_model'
import type { MendDraft } from './mend_model'
import { useUnsavedGuard } from './route'

export interface MendDesk {
  /** null: not read yet */
  mending: Mending | null
  strokes: ClickFile<MendStroke>
  /** the mesh as it is without any stroke; null: not loaded */
  before: MeshData | null
  /** with the strokes; null: being made */
  draft: MendDraft | null
  /** why the strokes cannot be done together, or '' */
  fault: string
  /** Adds a stroke, if it can be done. */
  paint: (stroke: MendStroke) => void
}

export function useMending(pose: string): MendDesk {
  const { version, reload, tell, complain } = useStudio()
  const [mending, setMending] = useState<Mending | null>(null)
  const [before, setBefore] = useState<MeshData | null>(null)
  const [draft, setDraft] = useState<MendDraft | null>(null)
  const [fault, setFault] = useState('')
  const [, drawAgain] = useState(0)
  /** Strokes come one after the other, also where a hand is faster than the server. */
  const work = useRef(Promise.resolve())
  const drafted = useRef<{ strokes: readonly MendStroke[]; mesh: MeshData } | null>(null)
  const strokes = useMemo(() => {
    const store = {
      save: async (list: readonly MendStroke[], revision: string) => {
        const now = await api.saveMending(pose, list, revision)
        // With the first stroke there is a step more, and the next run has something to do.
        void reload()
        return now.revision
      },
      read: async () => {
        const now = await api.mending(pose)
        setMending(now)
        return { clicks: now.strokes, revision: now.revision }
      },
    }
    return new ClickFile<MendStroke>(store, () => drawAgain((old) => old + 1), tell, 'strokes')
  }, [pose, tell, reload])
  useEffect(() => {
    let current = true
    const asked = strokes.moment
    api.mending(pose).then(
      (now) => {
        if (!current) return
        setMending(now)
        strokes.take(now.strokes, now.revision, asked)
        if (strokes.failed) void strokes.save()
      },
      (error: unknown) => current && complain(error),
    )
    return () => {
      current = false
    }
  }, [pose, version, strokes, complain])
  const mesh = mending?.mesh ?? ''
  useEffect(() => {
    let current = true
    setBefore(null)
    if (mesh)
      api.meshToMend(pose).then(
        (bytes) => current && setBefore(parseMesh(bytes)),
        (error: unknown) => current && complain(error),
      )
    return () => {
      current = false
    }
  }, [pose, mesh, complain])

  const make = async (list: readonly MendStroke[], on: MeshData) =>
    draftFrom(await api.draftMending(pose, list), on.vertices)
  const list = strokes.clicks
  const whole = list.every((stroke) => stroke.fault === '')
  useEffect(() => {
    if (!before || !whole) return
    if (drafted.current?.strokes === list && drafted.current.mesh === before) return
    let current = true
    make(list, before).then(
      (now) => {
        if (!current) return
        drafted.current = { strokes: list, mesh: before }
        setDraft(now)
        setFault('')
      },
      (error: unknown) => current && setFault(error instanceof Error ? error.message : String(error)),
    )
    return () => {
      current = false
    }
  }, [list, before, whole])

  const add = async (stroke: MendStroke) => {
    if (!before) return
    const next = [...strokes.clicks, stroke]
    try {
      const now = await make(next, before)
      const done = now.moved[now.moved.length - 1]
      if (done.vertices === 0)
        return complain('The brush is smaller than the triangles there; take a larger one.')
      drafted.current = { strokes: next, mesh: before }
      setDraft(now)
      setFault('')
      strokes.change('painted', next)
    } catch (error) {
      complain(error)
      drawAgain((old) => old + 1)
    }
  }
  const paint = (stroke: MendStroke) => {
    work.current = work.current.then(() => add(stroke))
  }
  useUnsavedGuard(strokes.failed !== '')
  return { mending, strokes, before, draft, fault, paint }
}

// The Viewer as a component. `ready` receives it once; the caller keeps it and calls its methods.
import { useEffect, useRef } from 'preact/hooks'
import type { ComponentChildren } from 'preact'

import { Viewer } from './viewer'

export function ViewerStage(props: {
  label: string
  ready: (viewer: Viewer | null) => void
  children?: ComponentChildren
}) {
  const host = useRef<HTMLDivElement>(null)
  const ready = useRef(props.ready)
  ready.current = props.ready
  useEffect(() => {
    const viewer = new Viewer(host.current!)
    ready.current(viewer)
    return () => {
      ready.current(null)
      viewer.dispose()
    }
  }, [])
  return (
    <section class="view" aria-label={props.label}>
      <div ref={host} style="position:absolute;inset:0" />
      {props.children}
    </section>
  )
}

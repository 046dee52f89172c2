// The plate, and the puppet over it.
import { useEffect, useRef } from 'preact/hooks'
import type { ComponentChildren } from 'preact'

import { PuppetView } from './puppet_view'
import type { Loaded } from './use_character'

/** The plate, and the puppet over it, in the picture's shape. */
export function PuppetStage(props: {
  loaded: Loaded
  plate: number
  free: boolean
  plateUrl: (index: number) => string
  /** gets the view while it is there */
  puppet: { current: PuppetView | null }
  children?: ComponentChildren
}) {
  const { loaded, plate, puppet } = props
  const { view, character } = loaded
  const host = useRef<HTMLDivElement>(null)
  const camera = view.views[Math.min(plate, view.views.length - 1)]
  useEffect(() => {
    const made = new PuppetView(host.current!, character)
    puppet.current = made
    return () => {
      puppet.current = null
      made.dispose()
    }
  }, [character, puppet])
  useEffect(() => puppet.current?.setCamera(camera), [camera, puppet])
  return (
    <div class="shoot-screen">
      <div class="shoot-picture">
        <div class="frame" style={`--shape:${camera.width / camera.height}`}>
          {view.pictures.length > 0 && !props.free ? (
            <img alt={`Plate ${plate + 1}`} src={props.plateUrl(plate)} />
          ) : (
            <div class="armature-backdrop" />
          )}
          <div ref={host} class="armature-canvas" />
        </div>
      </div>
      {props.children}
    </div>
  )
}

// A ring of the brush's size that goes with the pointer over a view.
import { useEffect, useRef } from 'preact/hooks'

import type { Viewer } from './viewer'

/** For an element of class `brush-ring` within the view. `radius`: of the figure's size. */
export function useBrushRing(viewer: Viewer | null, radius: number) {
  const ring = useRef<HTMLDivElement>(null)
  useEffect(() => {
    const canvas = viewer?.element
    if (!viewer || !canvas) return
    const follow = (event: PointerEvent) => {
      const hit = viewer.hitAt(event.clientX, event.clientY)
      const box = canvas.getBoundingClientRect()
      const shape = ring.current?.style
      if (!shape) return
      shape.display = hit ? 'block' : 'none'
      if (!hit) return
      const size_px = 2 * viewer.pixelsOf(radius, hit.place)
      shape.width = shape.height = `${size_px}px`
      shape.left = `${event.clientX - box.left - size_px / 2}px`
      shape.top = `${event.clientY - box.top - size_px / 2}px`
    }
    const leave = () => ring.current && (ring.current.style.display = 'none')
    canvas.addEventListener('pointermove', follow)
    canvas.addEventListener('pointerleave', leave)
    return () => {
      canvas.removeEventListener('pointermove', follow)
      canvas.removeEventListener('pointerleave', leave)
    }
  }, [viewer, radius])
  return ring
}

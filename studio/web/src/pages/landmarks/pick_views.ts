// The two views of the page: what they show of the picks, and how they turn together.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks'

import { api, ApiError } from '../../api'
import type { Advice } from '../../api'
import { useStudio } from '../../state'
import type { Hit, Turn, Viewer } from '../../view/viewer'
import { followed } from './linked_turn'
import type { Surfaces } from './looking'
import { kAdviceSigns, markersOf } from './markers'
import type { Meaning, Side } from './markers'
import type { Picking } from './picking'
import type { Surface } from './surface'

/** Places that the server advises for the next landmark; none before the first registration. */
export function useAdvice(pose: string): Advice[] {
  const { version, complain } = useStudio()
  const [advice, setAdvice] = useState<{ pose: string; list: Advice[] }>({ pose, list: [] })
  useEffect(() => {
    let wanted = true
    api.advice(pose).then(
      (list) => wanted && setAdvice({ pose, list: list.slice(0, kAdviceSigns.length) }),
      (error) => {
        const none = error instanceof ApiError && error.status === 404
        if (!none) complain(error)
      },
    )
    return () => {
      wanted = false
    }
  }, [pose, version, complain])
  return advice.pose === pose ? advice.list : []
}

/** `follower` makes each movement of `viewer`; returns what ends it. */
function link(viewer: Viewer, follower: Viewer): () => void {
  let last: Turn | null = null
  const remember = () => (last = viewer.turn())
  // A turn is told of after it was made, so the one before is kept when it begins.
  const begins = ['pointerdown', 'wheel', 'keydown'] as const
  for (const begin of begins) viewer.element.addEventListener(begin, remember, { capture: true })
  viewer.onTurn = (turn) => {
    if (last) follower.setTurn(followed(last, turn, follower.turn()))
    last = turn
  }
  return () => {
    viewer.onTurn = null
    for (const begin of begins)
      viewer.element.removeEventListener(begin, remember, { capture: true })
  }
}

/** Makes each view follow the other's turning while `together`. */
export function useLinkedTurns(surfaces: Surfaces, together: boolean): void {
  const one = surfaces.template.viewer
  const two = surfaces.pose.viewer
  useEffect(() => {
    if (!one || !two || !together) return
    two.setTurn(one.turn())
    const unlink = [link(one, two), link(two, one)]
    return () => unlink.forEach((undo) => undo())
  }, [one, two, together])
}

/** Shows the markers of one side and passes on what is done to them. */
export function useMarkers(
  side: Side,
  surface: Surface,
  picking: Picking,
  advice: Advice[],
  onHit: (hit: Hit) => void,
): void {
  const { viewer, data } = surface
  const meanings = useRef<Meaning[]>([])
  const show = () => {
    if (!viewer) return
    // Another pose's mesh may still be there while the next one loads.
    if (!data) return viewer.setMarkers([])
    const problems = new Set(picking.problems.keys())
    meanings.current = markersOf(side, viewer, { ...picking, problems, advice })
    viewer.setMarkers(meanings.current.map((one) => one.marker))
  }
  // Shown again only when something of it changes: a label is a small picture.
  const key = JSON.stringify([
    picking.items,
    picking.chosen,
    picking.pending,
    [...picking.problems],
    advice,
  ])
  useEffect(show, [viewer, data, side, key])
  // At once, not after the next frame: a click must not meet what was true before the last one.
  useLayoutEffect(() => {
    if (!viewer) return
    const idOf = (label: string) => meanings.current.find((one) => one.marker.name === label)?.id
    viewer.onPick = (hit) => {
      if (!hit || !data) return
      onHit(hit)
      picking.pick(side, hit)
    }
    viewer.onMarker = (label) => {
      const id = idOf(label) ?? ''
      if (id.startsWith('advice:')) picking.takeAdvice(Number(id.slice('advice:'.length)))
      else if (id !== '') picking.setChosen(id)
      show() // a hand that trembled has moved the marker
    }
    viewer.onMarkerDrag = (label, hit, done) => {
      const id = idOf(label) ?? ''
      const fixed = id.startsWith('advice:') || id.startsWith('suggestion:')
      if (fixed) return
      viewer.moveMarker(label, hit.place)
      if (done) picking.move(side, picking.itemOf(id), hit)
    }
  })
}

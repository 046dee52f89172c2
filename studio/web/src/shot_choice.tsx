import type { ComponentChildren } from 'preact'
import { useState } from 'preact/hooks'

import type { Pose } from './api'
import { useStudio } from './state'

/** A page about one shot of a performance; where there are several, buttons choose. */
export function ShotPage(props: {
  title: string
  kind: string
  show: (shot: Pose) => ComponentChildren
}) {
  const { project } = useStudio()
  const [name, setName] = useState('')
  const shot = project.poses.find((pose) => pose.name === name) ?? project.poses[0]
  return (
    <main class={`page whole ${props.kind}`}>
      <h1 class="hidden">{props.title}</h1>
      {project.poses.length > 1 && (
        <div class="choice" role="group" aria-label="Shot">
          {project.poses.map((pose) => (
            <button
              key={pose.name}
              aria-pressed={pose.name === shot.name}
              onClick={() => setName(pose.name)}
            >
              {pose.name}
            </button>
          ))}
        </div>
      )}
      {shot && props.show(shot)}
    </main>
  )
}

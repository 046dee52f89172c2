// The poses, and what the chosen one has.
import type { Pose, Steps } from '../../api'
import { useStudio } from '../../state'
import { count, stepName } from '../../words'
import { BinList } from './bin_list'
import { PoseNames } from './pose_names'
import { addressOf } from './route'
import { isFromMesh } from './tabs'

/** A step that fails with these words needs to be told what the figure is. */
export const kAsksForFigure = 'keypose figure'

export function PoseSide(props: {
  current: Pose
  choose: (name: string) => void
  /** asks for a new pose */
  add: () => void
}) {
  const { current, choose, add } = props
  return (
    <aside class="side" aria-label="Poses">
      <nav aria-labelledby="poses-title" class="stack">
        <h2 class="label" id="poses-title">Poses</h2>
        <PoseNames current={current} choose={choose} />
        <div class="row">
          <button class="quiet small" onClick={add}>
            New pose …
          </button>
          <BinList />
        </div>
      </nav>
      <Has pose={current} />
      <Next pose={current} />
    </aside>
  )
}

function Has({ pose }: { pose: Pose }) {
  const fitted = pose.method === 'fit'
  const mesh = pose.template ? 'Mesh' : fitted ? 'The net, bent into it' : 'The net, laid on it'
  const rows: [string, boolean, string][] = [
    ...(isFromMesh(pose)
      ? ([['Given', true, pose.mesh]] as typeof rows)
      : ([
          [
            'Photographs',
            pose.photographs > 0,
            `${pose.photographs}${pose.left_out > 0 ? `, ${pose.left_out} left out` : ''}`,
          ],
          ['Masks of your own', pose.masks !== '', pose.masks || 'none'],
          ['Cameras', pose.has_cameras, ''],
        ] as typeof rows)),
    ...(fitted ? [] : ([['Surface', pose.meshes.includes('clean'), '']] as typeof rows)),
    ...(fitted || pose.template
      ? []
      : ([['Landmarks', pose.has_landmarks, '']] as typeof rows)),
    [mesh, pose.meshes.includes('mesh'), ''],
    ['Texture', pose.has_texture, ''],
  ]
  return (
    <section class="stack" aria-labelledby="has-title">
      <h2 class="label" id="has-title">So far</h2>
      <ul class="has">
        {rows.map(([what, there, words]) => (
          <li key={what} class={there ? '' : 'soft'}>
            <span aria-hidden="true" class={there ? 'good' : 'soft'}>
              {there ? '✓' : '·'}
            </span>
            <span>{what}</span>
            <span class="small soft number">{words || (there ? '' : 'not yet')}</span>
          </li>
        ))}
      </ul>
    </section>
  )
}

function Next({ pose }: { pose: Pose }) {
  const { project, steps } = useStudio()
  const { text, page } = nextOf(pose, steps, project.poses.length === 1)
  const words = {
    run: 'Open Run',
    landmarks: 'Open Landmarks',
    figure: 'Show it',
    shoot: 'Shoot a second pose',
  }
  const address = page === 'figure' ? addressOf({ pose: pose.name, tab: page, item: '' }) : `#/${page}`
  return (
    <section class="next" aria-labelledby="next-title">
      <h2 class="label" id="next-title">Next</h2>
      <p>{text}</p>
      {page && <a href={address}>{words[page]} ›</a>}
    </section>
  )
}

/** What the person does next with a pose. */
function nextOf(
  pose: Pose,
  steps: Steps,
  alone: boolean,
): { text: string; page?: 'run' | 'landmarks' | 'figure' | 'shoot' } {
  const own = steps.steps.filter((step) => step.pose === pose.name)
  const failed = own.find((step) => step.state === 'failed')
  const open = own.filter((step) => ['would_run', 'never', 'waits'].includes(step.state))
  const registered = pose.meshes.includes('mesh')
  const first = own.find((step) => step.state !== 'done' && step.state !== 'missing')
  if (pose.photographs === 0 && !isFromMesh(pose))
    return { text: 'Drop photographs of this pose on the page.' }
  if (failed?.error.includes(kAsksForFigure))
    return { text: 'Show what the figure is: the photographs alone do not tell.', page: 'figure' }
  if (failed) return { text: `${stepName(failed.id, own)} failed. Its log says why.`, page: 'run' }
  if (steps.running && first) return { text: `A run is at work; “${stepName(first.id, own)}” is still to come.` }
  if (first?.stage === 'register' && !pose.has_landmarks && !registered)
    return { text: 'Pick a few landmarks; then the net can be laid on this pose.', page: 'landmarks' }
  if (open.length > 0)
    return { text: `Press Run: ${count(open.length, 'step')} from “${stepName(open[0].id, own)}” on.`, page: 'run' }
  if (pose.method === 'fit')
    return { text: 'All is made. Compare it with its photographs in the wipe.' }
  if (pose.template && alone && !isFromMesh(pose))
    return {
      text:
        'All is made. A second pose makes it move: six photographs are enough, shot, or dropped ' +
        'on this page.',
      page: 'shoot',
    }
  if (pose.template)
    return {
      text: `All is made. Look over the mesh in 3D${isFromMesh(pose) ? '' : ' and in the wipe'}.`,
    }
  return {
    text: 'All is made. Look at the fit; a landmark helps where it is yellow.',
    page: 'landmarks',
  }
}

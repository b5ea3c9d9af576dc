import java.io.File;
import java.util.ArrayList;
import java.util.List;
import org.eclipse.emf.common.util.Diagnostic;
import org.eclipse.emf.common.util.URI;
import org.eclipse.emf.ecore.EObject;
import org.eclipse.emf.ecore.EPackage;
import org.eclipse.emf.ecore.resource.Resource;
import org.eclipse.emf.ecore.resource.ResourceSet;
import org.eclipse.emf.ecore.resource.impl.ResourceSetImpl;
import org.eclipse.emf.ecore.util.Diagnostician;
import org.eclipse.emf.ecore.util.EcoreUtil;
import org.eclipse.emf.ecore.xmi.impl.EcoreResourceFactoryImpl;
import org.eclipse.emf.ecore.xmi.impl.XMIResourceFactoryImpl;

/**
 * Loads .ecore files and instances of them with the Eclipse Modeling Framework and prints what its own
 * validation says: "FILE: ok COUNT objects", or a line per problem. Exit status 1 when there is one.
 */
public final class EmfValidator {
    private static boolean sound = true;

    public static void main(String[] arguments) {
        ResourceSet set = new ResourceSetImpl();
        set.getResourceFactoryRegistry().getExtensionToFactoryMap().put("ecore", new EcoreResourceFactoryImpl());
        set.getResourceFactoryRegistry().getExtensionToFactoryMap().put("*", new XMIResourceFactoryImpl());
        List<Resource> resources = new ArrayList<>();
        for (String file : arguments) {
            Resource resource = set.getResource(URI.createFileURI(new File(file).getAbsolutePath()), true);
            for (EObject root : resource.getContents()) {
                if (root instanceof EPackage) {
                    EPackage found = (EPackage) root;
                    set.getPackageRegistry().put(found.getNsURI(), found);
                }
            }
            resources.add(resource);
        }
        EcoreUtil.resolveAll(set);
        for (Resource resource : resources) {
            report(resource);
        }
        System.exit(sound ? 0 : 1);
    }

    private static void report(Resource resource) {
        String name = resource.getURI().lastSegment();
        int count = 0;
        for (var all = resource.getAllContents(); all.hasNext(); all.next()) {
            count++;
        }
        for (Resource.Diagnostic error : resource.getErrors()) {
            problem(name, error.toString());
        }
        for (EObject root : resource.getContents()) {
            print(name, Diagnostician.INSTANCE.validate(root));
        }
        if (!EcoreUtil.UnresolvedProxyCrossReferencer.find(resource).isEmpty()) {
            problem(name, "unresolved references");
        }
        System.out.println(name + ": ok " + (count + resource.getContents().size()) + " objects");
    }

    private static void print(String name, Diagnostic diagnostic) {
        if (diagnostic.getSeverity() > Diagnostic.INFO && diagnostic.getChildren().isEmpty()) {
            problem(name, diagnostic.getMessage());
        }
        for (Diagnostic child : diagnostic.getChildren()) {
            print(name, child);
        }
    }

    private static void problem(String name, String message) {
        sound = false;
        System.out.println(name + ": PROBLEM " + message);
    }
}
